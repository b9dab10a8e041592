#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/sample_points.h"
#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/point_placement.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Builds the levels of a basis on the surfaces of a scene: point placement, adjacency (BasisSight) and means over
// surfels, kept in step. All that it refers to must outlive it; `basis` is what it fills.
class PlacedBasis {
public:
    struct Options {
        double radius = 0.0;  // as PlacementOptions has it
        int levels;           // at most
        double widest;        // as SurfelMeans has it
        std::uint64_t seed;
        MeshlessTuning tuning = {};
    };
    PlacedBasis(const Scene& scene, const Tracer& tracer, const SurfelPoints& points, MultilevelBasis& basis,
                const Options& options, const Progress& progress);

    // The coarsest level. After Poisson disks it has functions for nooks: behind walls, or smaller than the disks.
    void add_first(const Progress& progress);
    // The next, around functions of the last.
    void add_around(const std::vector<std::uint32_t>& refined, const Progress& progress);
    // Appends a level at the same points, of the receivers on disks that are spaced by 3 disk radii or less: a sum of
    // Shepard functions does not go through the values at its points, and this level holds the residual there. Returns
    // of each new function the one that it repeats; empty if there are none such.
    std::vector<std::uint32_t> repeat(const Receivers& receivers, const Progress& progress);

    const BasisSight& sight() const { return sight_; }
    const SurfelMeans& means() const { return means_; }
    // Those of functions at surfels, which take much memory, once all levels have been asked for them.
    void forget_weights() { means_.forget_weights(); }
    const std::vector<double>& first_radius() const { return placement_.points().first_radius; }
    std::uint32_t evenly_placed() const { return evenly_placed_; }
    // Is a function of the first level there for a nook?
    bool is_in_nook(std::uint32_t function) const { return function >= evenly_placed_ && function < basis_.first(1); }

private:
    void add_level(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                   const std::vector<std::uint32_t>& objects, const std::vector<std::uint32_t>& surfels,
                   const SupportOptions& support, const Progress& progress);
    void add_placed(const SupportOptions& support, const Progress& progress);

    const Scene& scene_;
    const Tracer& tracer_;
    const SurfelPoints& points_;
    MultilevelBasis& basis_;
    const MeshlessTuning tuning_;
    PointPlacement placement_;
    BasisSight sight_;
    SurfelMeans means_;
    std::uint32_t evenly_placed_ = 0;  // functions of the first level
    std::uint32_t to_repeat_ = 0;      // functions on levels before the first repeat
};

}  // namespace surflux
