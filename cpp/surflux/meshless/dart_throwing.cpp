#include "surflux/meshless/dart_throwing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/inside.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 256;

struct Round {
    const Scene& scene;
    const PointGrid& grid;              // of the points so far
    const std::vector<double>& radius;  // of each object
    std::vector<double> edge;           // of the cells of each object
    double shortest_edge;               // that can be halved: positions are rounded
    const SignedDistance& region;
    bool culls;  // cells outside the region
    double darts_on_square;
};

Vec3 center_of(const Triangle& t) { return (t.a + t.b + t.c) / 3.0; }

double longest_edge_squared(const Triangle& t) {
    return std::max({length_squared(t.b - t.a), length_squared(t.c - t.b), length_squared(t.a - t.c)});
}

// The halves on both sides of the middle of the longest edge: slivers, too, come into pieces about as long as wide.
std::array<Triangle, 2> bisect(const Triangle& t) {
    const double ab = length_squared(t.b - t.a), bc = length_squared(t.c - t.b), ca = length_squared(t.a - t.c);
    if (ab < std::max(bc, ca)) return bisect({t.b, t.c, t.a, t.surfel});
    const Vec3 middle = 0.5 * (t.a + t.b);
    return {{{t.c, t.a, middle, t.surfel}, {t.b, t.c, middle, t.surfel}}};
}

// Is a place on a surface with that normal in the exclusion disk of a point?
bool holds(const PointGrid::Point& p, double radius, const Vec3& place, const Vec3& normal) {
    const double r = radius * std::max(0.0, dot(p.normal, normal));
    return length_squared(p.position - place) < r * r;
}

// What a round makes of some of the cells.
struct Thrown {
    const Round* round;
    std::vector<Triangle> cells;          // that are not covered
    std::vector<PointGrid::Point> darts;  // that are free

    void on(const Triangle& t, Random& random) {
        const std::uint32_t object = round->scene.object[t.surfel];
        const Vec3& normal = round->scene.surfels.normals[t.surfel];
        const double r = round->radius[object], edge = round->edge[object],
                     longest = std::sqrt(longest_edge_squared(t));
        const auto covers = [&](const PointGrid::Point& p) {
            return holds(p, r, t.a, normal) && holds(p, r, t.b, normal) && holds(p, r, t.c, normal);
        };
        if (longest < 2.0 * r && round->grid.any_near(t.a, object, covers)) return;
        if (round->culls && is_outside(t)) return;
        if (longest > std::max(edge, round->shortest_edge)) {
            for (const Triangle& half : bisect(t)) on(half, random);
            return;
        }
        cells.push_back(t);
        if (random.uniform() * edge * edge >= round->darts_on_square * surface_area(round->scene, t)) return;
        const double s = random.uniform();
        const Vec3 w = square_to_triangle(s, random.uniform()), at = t.a + w.y * (t.b - t.a) + w.z * (t.c - t.a);
        const auto holds_dart = [&](const PointGrid::Point& p) { return holds(p, r, at, normal); };
        if (!round->grid.any_near(at, object, holds_dart) && distance(at, t.surfel) <= 0.0)
            darts.push_back({at, normal, object, t.surfel, random.bits()});
    }

    double distance(const Vec3& place, std::uint32_t surfel) const {
        if (!round->region) return 0.0;
        return round->region(place, round->scene.surfels.normals[surfel], round->scene.object[surfel]);
    }

    bool is_outside(const Triangle& t) const {
        const Vec3 center = center_of(t);
        const double d = distance(center, t.surfel);
        return d > 0.0 && d * d > std::max({length_squared(t.a - center), length_squared(t.b - center),
                                            length_squared(t.c - center)});
    }
};

// Throws darts; the cells become those of this round.
std::vector<PointGrid::Point> throw_on(std::vector<Triangle>& cells, const Round& round, std::uint64_t seed,
                                       const Progress& progress) {
    std::vector<Thrown> thrown((cells.size() + grain - 1) / grain);
    parallel_blocks(
        cells.size(), grain,
        [&](std::size_t begin, std::size_t end) {
            Thrown t{&round, {}, {}};
            for (std::size_t k = begin; k < end; ++k) {
                Random random(seed, k);
                t.on(cells[k], random);
            }
            thrown[begin / grain] = std::move(t);
        },
        progress);
    std::size_t count = 0;
    for (const Thrown& t : thrown) count += t.cells.size();
    cells.clear();
    cells.reserve(count);
    std::vector<PointGrid::Point> darts;
    for (Thrown& t : thrown) {
        cells.insert(cells.end(), t.cells.begin(), t.cells.end());
        darts.insert(darts.end(), t.darts.begin(), t.darts.end());
        t = Thrown();
    }
    return darts;
}

// Those of least priority among the ones in conflict with each.
std::vector<PointGrid::Point> without_conflicts(const std::vector<PointGrid::Point>& darts,
                                                const std::vector<double>& radius) {
    const PointGrid grid(darts, radius);
    std::vector<char> is_first(darts.size());
    parallel_for(darts.size(), grain, [&](std::size_t k) {
        const PointGrid::Point& d = darts[k];
        is_first[k] = !grid.any_near(d.position, d.object, [&](const PointGrid::Point& p) {
            return p.priority < d.priority && holds(p, radius[d.object], d.position, d.normal);
        });
    });
    std::vector<PointGrid::Point> out;
    for (std::size_t k = 0; k < darts.size(); ++k)
        if (is_first[k]) out.push_back(darts[k]);
    return out;
}

// Removes what is inside geometry at all of `count` places: place_of(it, 0), place_of(it, 1), ...
template <class T, class PlaceOf>
void remove_inside(const Scene& scene, const Tracer& tracer, std::uint64_t seed, std::size_t count,
                   const MeshlessTuning& tuning, const PlaceOf& place_of, std::vector<T>& of) {
    std::vector<char> is_inside(of.size(), 1);
    for (std::size_t c = 0; c < count; ++c) {
        std::vector<std::size_t> tested;
        std::vector<Departure> places;
        for (std::size_t k = 0; k < of.size(); ++k)
            if (is_inside[k]) tested.push_back(k), places.push_back(place_of(of[k], c));
        const std::vector<char> found = inside_geometry(scene, tracer, places, seed, tuning);
        for (std::size_t j = 0; j < tested.size(); ++j) is_inside[tested[j]] = found[j];
    }
    std::size_t left = 0;
    for (std::size_t k = 0; k < of.size(); ++k)
        if (!is_inside[k]) of[left++] = of[k];
    of.resize(left);
}

}  // namespace

std::vector<PointGrid::Point> throw_darts(const Scene& scene, const Tracer& tracer, const Surface& surface,
                                          const std::vector<PointGrid::Point>& there, const DartOptions& options,
                                          const Progress& progress) {
    const std::vector<double>& radius = options.radius;
    const MeshlessTuning& tuning = options.tuning;
    const double first_edge = tuning.first_edge, culled_edge = tuning.culled_edge;
    std::vector<double> last;  // edges
    int rounds = 0;
    for (std::size_t o = 0; o < radius.size(); ++o) {
        last.push_back(std::min(tuning.last_edge * radius[o],
                                std::sqrt(surface.area[o] * tuning.darts_on_square / tuning.least_darts)));
        if (last[o] > 0.0)
            rounds = std::max(rounds, 1 + static_cast<int>(std::ceil(std::log2(first_edge * radius[o] / last[o]))));
    }
    const Box box = bounds_of(scene.surfels);
    const double shortest_edge = 1e-14 * std::max(length(box.low), length(box.high));
    std::vector<Triangle> cells = surface.triangles;
    std::vector<PointGrid::Point> points = there;
    for (int k = 0; k < rounds && !cells.empty(); ++k) {
        const double in_radii = std::ldexp(first_edge, -k);
        std::vector<double> edge;
        for (std::size_t o = 0; o < radius.size(); ++o) edge.push_back(std::max(last[o], in_radii * radius[o]));
        const PointGrid grid(points, radius);
        const bool culls = options.region && in_radii >= culled_edge;
        const Progress in_round = [&](std::size_t done, std::size_t of) {
            const double all = (k + static_cast<double>(done) / static_cast<double>(of)) / rounds;
            return progress(static_cast<std::size_t>(999.0 * all), 1000);
        };
        const std::uint64_t seed = Random(options.seed, static_cast<std::uint64_t>(k)).bits();
        std::vector<PointGrid::Point> darts =
            throw_on(cells, {scene, grid, radius, edge, shortest_edge, options.region, culls, tuning.darts_on_square},
                     seed, progress ? in_round : progress);
        const auto place_of_dart = [](const PointGrid::Point& p, std::size_t) {
            return Departure{p.position, p.normal, p.surfel};
        };
        remove_inside(scene, tracer, seed, 1, tuning, place_of_dart, darts);
        const auto place_on_cell = [&](const Triangle& t, std::size_t c) {
            const Vec3 center = center_of(t), places[] = {center, t.a, t.b, t.c};
            return Departure{places[c] + 0.01 * (center - places[c]), scene.surfels.normals[t.surfel], t.surfel};
        };
        if (in_radii <= culled_edge && 2.0 * in_radii > culled_edge)
            remove_inside(scene, tracer, seed, 4, tuning, place_on_cell, cells);
        const std::vector<PointGrid::Point> chosen = without_conflicts(darts, radius);
        points.insert(points.end(), chosen.begin(), chosen.end());
    }
    report(progress, 1000, 1000);
    return {points.begin() + static_cast<std::ptrdiff_t>(there.size()), points.end()};
}

}  // namespace surflux
