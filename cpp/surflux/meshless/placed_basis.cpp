#include "surflux/meshless/placed_basis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "surflux/meshless/refined_region.h"
#include "surflux/meshless/wall_cuts.h"

namespace surflux {

namespace {

double at_level(double first, std::size_t level) { return first * std::pow(0.5, static_cast<double>(level)); }

}  // namespace

PlacedBasis::PlacedBasis(const Scene& scene, const Tracer& tracer, const SurfelPoints& points, MultilevelBasis& basis,
                         const Options& options, const Progress& progress)
    : scene_(scene),
      tracer_(tracer),
      points_(points),
      basis_(basis),
      tuning_(options.tuning),
      placement_(scene, tracer, {options.radius, options.seed, options.tuning}),
      sight_(scene, tracer, basis, options.tuning),
      means_(scene, tracer, points, basis, sight_, placement_.points().first_radius,
             {options.levels, options.widest, options.seed, options.tuning}, progress) {}

void PlacedBasis::add_first(const Progress& progress) {
    placement_.add_level({}, progress);
    const PlacedPoints& points = placement_.points();
    evenly_placed_ = static_cast<std::uint32_t>(points.size());
    std::vector<Vec3> positions = points.positions, normals = points.normals;
    std::vector<std::uint32_t> objects = points.objects, surfels = points.surfels;
    basis_.add_level(positions, normals, objects);
    sight_.extend(surfels, progress);
    SupportOptions support;
    for (std::uint32_t j = 0; j < evenly_placed_; ++j) support.radii.push_back(basis_.radius(0, j));
    std::vector<Departure> asked, on_one;
    for (std::uint32_t i = 0; i < scene_.surfels.size(); ++i) {
        if (means_.is_wide(i)) {
            means_.outside_places(i, on_one);
            asked.insert(asked.end(), on_one.begin(), on_one.end());
        } else if (means_.outside(i) > 0.0 && !sight_.is_cloud(scene_.object[i])) {
            asked.push_back({scene_.surfels.positions[i], scene_.surfels.normals[i], i});
        }
    }
    for (const std::vector<std::uint32_t>& nook : sight_.nooks(asked, first_radius(), progress)) {
        // Surfels are in a nook as a whole, but for wide patches: of these, places have what functions they see.
        std::vector<std::uint32_t> whole;
        for (const std::uint32_t k : nook)
            if (!means_.is_wide(asked[k].surfel)) whole.push_back(asked[k].surfel);
        sight_.set_nook(whole, static_cast<std::uint32_t>(positions.size()));
        const Departure& at = asked[nook[0]];
        const std::uint32_t object = scene_.object[at.surfel];
        positions.push_back(at.position);
        normals.push_back(at.normal);
        objects.push_back(object);
        surfels.push_back(at.surfel);
        double farthest = 0.0;
        for (const std::uint32_t k : nook)
            if (means_.is_wide(asked[k].surfel)) farthest = std::max(farthest, length(asked[k].position - at.position));
        support.radii.push_back(whole.size() < nook.size() ? std::max(tuning_.beyond_nook * farthest,
                                                                      tuning_.least_nook * first_radius()[object])
                                                           : 0.0);
    }
    basis_ = MultilevelBasis();
    sight_.clear();
    add_level(positions, normals, objects, surfels, support, progress);
}

void PlacedBasis::add_around(const std::vector<std::uint32_t>& refined, const Progress& progress) {
    const std::size_t level = basis_.levels();
    placement_.add_level(refined_region(basis_, refined, first_radius(), tuning_.placed_reach), progress);
    SupportOptions support;
    for (const double r : first_radius())
        support.largest_radii.push_back(std::max(1e-300, tuning_.widest_support * at_level(r, level)));
    add_placed(support, progress);
}

std::vector<std::uint32_t> PlacedBasis::repeat(const Receivers& receivers, const Progress& progress) {
    if (to_repeat_ == 0) to_repeat_ = static_cast<std::uint32_t>(basis_.size());
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects, surfels, repeated;
    for (std::uint32_t j = 0; j < to_repeat_; ++j) {
        const std::uint32_t i = sight_.surfel(j), o = basis_.object(j);
        if (points_.is_patch(i) || !receivers.has(j)) continue;
        const double spacing = at_level(first_radius()[o], basis_.level_of(j));
        if (spacing > tuning_.widest_spacing * scene_.surfels.radii[i]) continue;
        positions.push_back(basis_.position(j));
        normals.push_back(basis_.normal(j));
        objects.push_back(o);
        surfels.push_back(i);
        repeated.push_back(j);
    }
    if (!repeated.empty()) add_level(positions, normals, objects, surfels, {}, progress);
    return repeated;
}

// The level that is placed last.
void PlacedBasis::add_placed(const SupportOptions& support, const Progress& progress) {
    const PlacedPoints& points = placement_.points();
    const auto from = static_cast<std::ptrdiff_t>(points.level_begin[points.level_begin.size() - 2]);
    add_level({points.positions.begin() + from, points.positions.end()},
              {points.normals.begin() + from, points.normals.end()},
              {points.objects.begin() + from, points.objects.end()},
              {points.surfels.begin() + from, points.surfels.end()}, support, progress);
}

void PlacedBasis::add_level(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                            const std::vector<std::uint32_t>& objects, const std::vector<std::uint32_t>& surfels,
                            const SupportOptions& support, const Progress& progress) {
    basis_.add_level(positions, normals, objects, support);
    sight_.extend(surfels, progress);
    basis_.set_cuts(wall_cuts(scene_, tracer_, basis_, sight_, tuning_, progress));
    means_.extend(placement_.points().level_begin.size() - 2, progress);
}

}  // namespace surflux
