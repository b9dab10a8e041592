#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/surface.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct PlacementOptions {
    // Least distance of two points of the first level on a plane. 0: each object has its own, such that all have about
    // tuning.coarsest_points there, in proportion to their areas, but each about tuning.least_points at least.
    double radius = 0.0;
    std::uint64_t seed = 0;
    MeshlessTuning tuning = {};
};

// Points of all levels so far, level after level, and object after object within one.
struct PlacedPoints {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> surfels;    // of the scene, that each lies on
    std::vector<std::uint32_t> objects;    // reconstruction group of each
    std::vector<std::size_t> level_begin;  // of each level, and the end of the last
    std::vector<double> first_radius;      // per object; 0 where it has no area
    std::size_t size() const { return positions.size(); }
};

// Hierarchical Poisson disks on the surfaces of a scene, patches and disks alike (L07 6.1). Two points of an object,
// whatever their levels, are at least R max(0, n . n') apart, R of the finer one's level: R halves from level to level.
// Points inside geometry are left out. The scene and the tracer must outlive this.
class PointPlacement {
public:
    PointPlacement(const Scene& scene, const Tracer& tracer, const PlacementOptions& options);

    // Adds a level, in a region of the surfaces or, without one, everywhere.
    void add_level(const SignedDistance& region = {}, const Progress& progress = {});
    const PlacedPoints& points() const { return points_; }

private:
    const Scene& scene_;
    const Tracer& tracer_;
    PlacementOptions options_;
    Surface surface_;
    PlacedPoints points_;
};

}  // namespace surflux
