#include "surflux/trace/inward.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t links = 12;        // neighbours that may continue a surfel
constexpr double continuation = 0.5;     // least agreement of surfels that do
constexpr std::size_t witnesses = 2000;  // at most, of a sheet
constexpr double flattest = 0.3;         // cosine of a ray; nearer the disk it meets the rims of others
constexpr double closed = 0.6;           // part of the light that reaches a closed sheet from one side alone

Scene as_scene(const Surfels& surfels, bool turned) {
    Scene out;
    out.surfels = surfels;
    out.object.assign(surfels.size(), 0);
    if (turned) {
        for (Vec3& n : out.surfels.normals) n = -n;
        for (Triangle& t : out.surfels.triangles) std::swap(t.b, t.c);
    }
    return out;
}

// Share of the rays from the front of each of `from` that leave the scene.
std::vector<double> escapes(const Scene& scene, const std::vector<std::uint32_t>& from, const InwardOptions& options,
                            const Progress& progress) {
    const Surfels& s = scene.surfels;
    std::vector<double> out(from.size(), 0.0);
    if (from.empty()) return out;
    const Tracer tracer(scene);
    parallel_blocks(
        from.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = from[k];
                const Frame frame = frame_around(s.normals[i]);
                EvenPoints even(2, options.seed, i);
                for (int r = 0; r < options.rays; ++r) {
                    const double* u = even.next();
                    Vec3 d = square_to_cosine_hemisphere(u[0], u[1]);
                    d.z = std::max(d.z, flattest);
                    const Ray ray{{s.positions[i], s.normals[i], i}, frame.to_world(normalized(d))};
                    if (tracer.free(ray)) out[k] += 1.0 / options.rays;
                }
            }
        },
        progress);
    return out;
}

struct Surroundings {
    NeighborGraph graph;
    std::vector<double> spacing;
    std::vector<bool> two_sided;  // shares its place with one that faces elsewhere: both are right
};

// Surfels at the same place are no neighbours, but have the same ones.
Surroundings surroundings_of(const Surfels& s, const Progress& progress) {
    const std::vector<Vec3>& positions = s.positions;
    const auto [places, of_surfel] = distinct_places(positions);
    std::vector<std::uint32_t> first(places.size());
    for (std::size_t i = positions.size(); i-- > 0;) first[of_surfel[i]] = static_cast<std::uint32_t>(i);
    const PointIndex index(places);
    Surroundings out{NeighborGraph(positions.size()), std::vector<double>(positions.size()),
                     std::vector<bool>(positions.size(), false)};
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::uint32_t other = first[of_surfel[i]];
        if (dot(s.normals[i], s.normals[other]) < 0.0) out.two_sided[i] = out.two_sided[other] = true;
    }
    parallel_blocks(
        positions.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(positions[i], links + 1, near);
                out.spacing[i] = near[std::min<std::size_t>(5, near.size() - 1)].distance;
                for (const Neighbor& n : near)
                    if (n.index != of_surfel[i]) out.graph[i].push_back(first[n.index]);
            }
        },
        progress);
    return out;
}

// Which surfels have to be turned.
std::vector<bool> find_inward(const Surfels& s, const Surroundings& around, const InwardOptions& options,
                              const Progress& progress) {
    std::vector<Vec3> consistent = s.normals;
    const std::vector<std::vector<std::uint32_t>> sheets =
        groups_of(orient_sheets(s.positions, around.spacing, around.graph, continuation, consistent, progress));
    std::vector<bool> turned(s.size());
    for (std::size_t i = 0; i < s.size(); ++i) turned[i] = dot(consistent[i], s.normals[i]) < 0.0;

    std::vector<std::uint32_t> asked;  // of each sheet in turn
    const auto count_of = [&](const std::vector<std::uint32_t>& sheet) {
        return options.rooms || sheet.size() < options.smallest ? 0 : std::min(sheet.size(), witnesses);
    };
    for (const std::vector<std::uint32_t>& sheet : sheets)
        for (std::size_t k = 0; k < count_of(sheet); ++k) asked.push_back(sheet[k * sheet.size() / count_of(sheet)]);
    const auto half = [&](std::size_t before) -> Progress {
        if (!progress) return {};
        return [&progress, before](std::size_t done, std::size_t total) { return progress(before + done, 2 * total); };
    };
    const std::vector<double> front = escapes(as_scene(s, false), asked, options, half(0));
    const std::vector<double> back = escapes(as_scene(s, true), asked, options, half(asked.size()));

    std::size_t at = 0;
    for (const std::vector<std::uint32_t>& sheet : sheets) {
        if (sheet.size() < options.smallest) continue;
        double light = 0.0, from_front = 0.0;
        for (std::size_t k = 0; k < count_of(sheet); ++k, ++at) {
            light += front[at] + back[at];
            from_front += turned[asked[at]] ? back[at] - front[at] : front[at] - back[at];
        }
        const auto against = std::count_if(sheet.begin(), sheet.end(), [&](std::uint32_t i) { return turned[i]; });
        const bool backwards = std::abs(from_front) > closed * light
                                   ? from_front < 0.0
                                   : 2 * static_cast<std::size_t>(against) > sheet.size();
        if (backwards)
            for (std::uint32_t i : sheet) turned[i] = !turned[i];
    }
    for (std::size_t i = 0; i < s.size(); ++i) turned[i] = turned[i] && !around.two_sided[i];
    return turned;
}

}  // namespace

std::vector<std::uint32_t> inward_patches(const Surfels& surfels, const InwardOptions& options,
                                          const Progress& progress) {
    std::vector<std::uint32_t> patch(surfels.size(), 0);
    if (surfels.size() < std::max<std::size_t>(options.smallest, 2)) return patch;
    const Surroundings around = surroundings_of(surfels, progress);
    const std::vector<bool> inward = find_inward(surfels, around, options, progress);

    // Patches: connected, and alike among themselves.
    std::vector<std::vector<std::uint32_t>> patches;
    std::vector<bool> reached(surfels.size(), false);
    for (std::uint32_t seed = 0; seed < surfels.size(); ++seed) {
        if (reached[seed] || !inward[seed]) continue;
        std::vector<std::uint32_t> members{seed};
        reached[seed] = true;
        for (std::size_t k = 0; k < members.size(); ++k) {
            const std::uint32_t i = members[k];
            for (std::uint32_t j : around.graph[i]) {
                if (reached[j] || !inward[j]) continue;
                const Vec3 d = surfels.positions[j] - surfels.positions[i];
                if (agreement(surfels.normals[i], surfels.normals[j], d) < continuation) continue;
                reached[j] = true;
                members.push_back(j);
            }
        }
        if (members.size() >= options.smallest) patches.push_back(std::move(members));
    }
    std::stable_sort(patches.begin(), patches.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    for (std::size_t k = 0; k < patches.size(); ++k)
        for (std::uint32_t i : patches[k]) patch[i] = static_cast<std::uint32_t>(k + 1);
    return patch;
}

}  // namespace surflux
