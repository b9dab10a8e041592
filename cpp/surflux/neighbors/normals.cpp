#include "surflux/neighbors/normals.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/surface_normal.h"

namespace surflux {

namespace {

// How many times the neighbours asked for a place may look at before it takes its normal from another one.
constexpr std::size_t farthest_look = 16;

// Neighbours that a place hands its orientation to. With more, the tree jumps to other sheets.
constexpr std::size_t tree_neighbors = 12;

// Places along a Morton curve: searches of one after the other then read the same parts of the tree and of the places,
// which a scan in no order has all over memory.
void along_a_curve(std::vector<Vec3>& places, std::vector<std::uint32_t>& of_point) {
    const std::vector<std::uint32_t> order = morton_order(places);
    std::vector<Vec3> ordered(places.size());
    std::vector<std::uint32_t> number(places.size());
    for (std::uint32_t k = 0; k < order.size(); ++k) {
        ordered[k] = places[order[k]];
        number[order[k]] = k;
    }
    places.swap(ordered);
    for (std::uint32_t& place : of_point) place = number[place];
}

// The distance to the fifth neighbour, or the last where there are fewer.
std::vector<double> spacings(const std::vector<Vec3>& places, const PointIndex& index, const Progress& progress) {
    std::vector<double> out(places.size());
    parallel_blocks(
        places.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(places[i], 6, near);
                out[i] = near.back().distance;
            }
        },
        progress);
    return out;
}

// Do the places scatter about the surface by so much that a fit has to average rather than follow them? The median of
// the misfits tells: on meshes it is at most .05 spacings, with Gaussian noise of a fifth of the distance to the
// nearest neighbour .09 to .11, on a scanned statue .08.
bool are_noisy(const std::vector<Vec3>& places, const std::vector<double>& spacing, const PointIndex& index,
               std::size_t neighbors) {
    const std::size_t samples = std::min<std::size_t>(places.size(), 10000);
    std::vector<double> misfits(samples);
    parallel_blocks(samples, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        SurfaceNormal surface_normal(places, spacing);
        for (std::size_t k = begin; k < end; ++k) {
            index.nearest(places[k * places.size() / samples], neighbors, near);
            misfits[k] = surface_normal.misfit(near);
        }
    });
    const auto middle = misfits.begin() + static_cast<std::ptrdiff_t>(samples / 2);
    std::nth_element(misfits.begin(), middle, misfits.end());
    return *middle > 0.065;
}

// Unoriented normals of places of their own, who is next to whom, and how many neighbours each had to look at.
std::vector<Vec3> fitted_normals(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                                 const PointIndex& index, std::size_t neighbors, bool noisy, NeighborGraph& graph,
                                 std::vector<std::uint32_t>& looks, const Progress& progress) {
    std::vector<Vec3> normals(places.size());
    parallel_blocks(
        places.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            SurfaceNormal surface_normal(places, spacing, noisy);
            for (std::size_t i = begin; i < end; ++i) {
                // Places on a line span no plane, those of one scan line hardly one, and those of two near sheets
                // several: look further until the neighbourhood is broad and flat, but not at all there are.
                Vec3 first;
                for (std::size_t k = neighbors;; k *= 2) {
                    index.nearest(places[i], k, near);
                    normals[i] = surface_normal(near);
                    looks[i] = static_cast<std::uint32_t>(k);
                    if (surface_normal.breadth() > 0.05 || k >= places.size()) break;
                    if (!(length_squared(first) > 0.0)) first = normals[i];
                    if (2 * k > farthest_look * neighbors) break;
                }
                // A wire is no surface however far one looks; the nearest neighbours know it best.
                if (surface_normal.breadth() <= 0.05 && length_squared(first) > 0.0) {
                    normals[i] = first;
                    looks[i] = static_cast<std::uint32_t>(neighbors);
                    near.resize(std::min(near.size(), neighbors));
                }
                const std::size_t others = near.size() - 1, links = std::min(others, tree_neighbors);
                const std::size_t spread = looks[i] > neighbors ? others : links;
                for (std::size_t k = 1; k <= links; ++k) {
                    const std::uint32_t j = near[k * spread / links].index;
                    if (j != i) graph[i].push_back(j);
                }
            }
        },
        progress);

    std::vector<std::uint32_t> with, without;
    for (std::uint32_t i = 0; i < places.size(); ++i) (length_squared(normals[i]) > 0.0 ? with : without).push_back(i);
    if (without.empty()) return normals;
    if (with.empty()) {
        std::vector<Neighbor> all;
        for (std::uint32_t i = 0; i < places.size(); ++i) all.push_back({i, 0.0});
        const Vec3 normal = plane_normal(places, all);
        require(length_squared(normal) > 0.0,
                "normals: the points lie on a line or coincide, so no surface can be fitted; give normals");
        normals.assign(places.size(), normal);
        return normals;
    }
    std::vector<Vec3> fitted;
    for (std::uint32_t i : with) fitted.push_back(places[i]);
    const PointIndex fitted_index(fitted);
    parallel_blocks(without.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t i = without[k];
            fitted_index.nearest(places[i], 1, near);
            const std::uint32_t giver = with[near[0].index];
            normals[i] = normals[giver];
            graph[i].push_back(giver);
        }
    });
    return normals;
}

// The fit of some places once more, among neighbours that face the same way. Where all that it was made of do, it would
// be the same.
void refine(const std::vector<Vec3>& places, const std::vector<double>& spacing, const PointIndex& index,
            const std::vector<std::uint32_t>& looks, bool noisy, const std::vector<std::uint32_t>& some,
            std::vector<Vec3>& normals, const Progress& progress) {
    const std::vector<Vec3> before = normals;
    parallel_blocks(
        some.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near, group, others;
            SurfaceNormal surface_normal(places, spacing, noisy);
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = some[k];
                const std::size_t neighbors = looks[i];
                index.nearest(places[i], neighbors * 3 / 2, near);
                const auto faces = [&](const Neighbor& n) {
                    return n.index == i || dot(before[n.index], before[i]) > 0.5;
                };
                const auto fitted = static_cast<std::ptrdiff_t>(std::min(near.size(), neighbors));
                if (std::all_of(near.begin(), near.begin() + fitted, faces)) continue;
                group.clear();
                others.clear();
                for (const Neighbor& n : near) (faces(n) ? group : others).push_back(n);
                if (others.empty() && near.size() <= neighbors) continue;
                // Too few fit anything: then the nearest of the others are better than none.
                for (std::size_t j = 0; j < others.size() && 2 * group.size() < neighbors; ++j)
                    group.push_back(others[j]);
                std::sort(group.begin(), group.end(), [](const Neighbor& a, const Neighbor& b) {
                    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
                });
                group.resize(std::min(group.size(), neighbors));
                const Vec3 n = surface_normal(group);
                if (std::abs(dot(n, before[i])) > 0.5) normals[i] = dot(n, before[i]) < 0.0 ? -n : n;
            }
        },
        progress);
}

// Places that one of the points wanted, or of all of them where that is empty, stands at.
std::vector<std::uint32_t> places_of(const std::vector<char>& wanted, const std::vector<std::uint32_t>& of_point,
                                     std::size_t places) {
    std::vector<char> some(places, wanted.empty());
    for (std::size_t i = 0; i < wanted.size(); ++i)
        if (wanted[i]) some[of_point[i]] = true;
    std::vector<std::uint32_t> out;
    for (std::uint32_t place = 0; place < places; ++place)
        if (some[place]) out.push_back(place);
    return out;
}

// Towards the viewpoint. Where it sees the surface edge on, a small error of the normal decides: there the neighbours
// that it sees better tell.
void face(const Vec3& viewpoint, const std::vector<Vec3>& places, const NeighborGraph& graph,
          std::vector<Vec3>& normals) {
    std::vector<bool> edge_on(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Vec3 d = viewpoint - places[i];
        const double toward = dot(d, normals[i]);
        edge_on[i] = std::abs(toward) <= 0.1 * length(d);
        if (toward < 0.0) normals[i] = -normals[i];
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (!edge_on[i]) continue;
        double sum = 0.0;
        for (std::uint32_t j : graph[i])
            if (!edge_on[j]) sum += agreement(normals[i], normals[j], places[j] - places[i]);
        if (sum < 0.0) normals[i] = -normals[i];
    }
}

}  // namespace

std::vector<Vec3> estimate_normals(const std::vector<Vec3>& points, const NormalOptions& options,
                                   const Progress& progress) {
    require(points.size() >= 3, "normals: wanted at least 3 points to estimate them from, got ", points.size(),
            "; give normals");
    require(options.wanted.empty() || options.wanted.size() == points.size(), "wanted: must be one for each of ",
            points.size(), " points, or none, got ", options.wanted.size());
    const Progress asked = standing_at(0, 2 * points.size(), progress);
    auto [places, of_point] = distinct_places(points, asked);
    along_a_curve(places, of_point);
    std::size_t neighbors = std::max<std::size_t>(options.neighbors, 3);
    const PointIndex index(places, asked);
    const std::vector<std::uint32_t> some = places_of(options.wanted, of_point, places.size());
    const std::size_t total = places.size() + some.size();
    // Steps beside the two fits, which count as all of the work, say that they are there, and are cancelled.
    const auto still = [&](std::size_t at) -> Progress {
        if (!progress) return {};
        return standing_at(at * 2 * points.size() / total, 2 * points.size(), progress);
    };
    const std::vector<double> spacing = spacings(places, index, still(0));
    const bool noisy = are_noisy(places, spacing, index, neighbors);
    if (noisy) neighbors += neighbors / 2;
    NeighborGraph graph(places.size());
    std::vector<std::uint32_t> looks(places.size());
    const auto fits = [&](std::size_t before) -> Progress {
        if (!progress) return {};
        return [&, before](std::size_t done, std::size_t) {
            return progress((before + done) * 2 * points.size() / total, 2 * points.size());
        };
    };
    std::vector<Vec3> normals = fitted_normals(places, spacing, index, neighbors, noisy, graph, looks, fits(0));
    if (options.viewpoint)
        face(*options.viewpoint, places, graph, normals);
    else
        orient_consistently(places, spacing, graph, normals, still(places.size()));
    graph = {};
    refine(places, spacing, index, looks, noisy, some, normals, fits(places.size()));
    std::vector<Vec3> out(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = normals[of_point[i]];
    return out;
}

}  // namespace surflux
