#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"

namespace surflux {

// The closest intersection of a ray.
struct Hit {
    static constexpr std::uint32_t none = 0xffffffffu;
    std::uint32_t surfel = none;
    // Met on the side that its normal points to, and not in contact with the place that the ray left: what faces that
    // so closely covers it, while the foot of a wall is as near, but faces elsewhere. All else absorbs.
    bool front = false;
    double distance = 0.0;  // along the ray, in units of its direction
    explicit operator bool() const { return surfel != none; }
};

// Origin of a ray on a surface: point, normal, and the surfel that it lies on (`none` for a point in the air).
struct Departure {
    Vec3 position, normal;
    std::uint32_t surfel = Hit::none;
};

struct Ray {
    Departure from;
    Vec3 direction;  // unit
    double length = std::numeric_limits<double>::infinity();
    std::uint32_t to = Hit::none;  // the surfel that a shadow ray arrives at; `none` for a light
};

// So far along their length shadow rays to lights look: what lies in the plane of a lamp does not block. Those to
// surfels look all the way, and pass what is one with the target alone: what stands closely before it blocks.
inline constexpr double short_of_target = 1.0 - 1e-5;

// The shadow ray from a place to a point of a surfel, or of a light.
Ray segment(const Departure& from, const Vec3& to, std::uint32_t surfel = Hit::none);

// Ray queries (closest hit and occlusion, by Embree) against the surfels of a scene: disks, up to their ends, and
// the triangles of those that have some, block from both sides. Self-intersection is avoided by one rule for all
// solvers: leaving surfel i, it ignores i itself, and those disks k of the same object, i within 2 R_k of their
// centres, that it crosses from behind: they stand off a convex surface or ridge that they are tangent to; those of
// other objects too, within the spread of their heights (Scene). So it does what it crosses from behind within twice
// the contact distance over where it begins, unless that faces the place: what lies in one plane is one surface.
// Arriving at a surfel or a light, the same seen backwards. On the way, rays pass under the rims of disks: they do not
// see the back of a disk where the surface of a neighbour lies below it, so that a closed convex cloud shows no backs.
// By index and side, not by distance alone: what touches i but faces elsewhere, or rises in front of it, blocks. Of
// patches that coincide a ray meets the one on top (Cover), of the two sides of a sheet the one that faces it (Sheet).
// Queries are const and may run on many threads at once.
class Tracer {
public:
    explicit Tracer(const Scene& scene, const Progress& progress = {});
    ~Tracer();
    Tracer(const Tracer&) = delete;
    Tracer& operator=(const Tracer&) = delete;

    // What a ray meets first within its length, at the end of which nothing is ignored.
    Hit closest(const Ray& ray) const;
    void closest(const std::vector<Ray>& rays, std::vector<Hit>& hits) const;
    // Is a shadow ray unoccluded up to its length, where it arrives at a surfel or a light? One without end: does it
    // leave the scene?
    bool free(const Ray& ray) const;
    void free(const std::vector<Ray>& rays, std::vector<char>& free) const;
    // The same of rays that go nearly the same way, as those of neighbouring pixels do: sixteen at once, in half the
    // time.
    void closest_coherent(const std::vector<Ray>& rays, std::vector<Hit>& hits) const;
    void free_coherent(const std::vector<Ray>& rays, std::vector<char>& free) const;
    // A point of a surfel, as a place to leave.
    Departure on(std::uint32_t surfel, const Vec3& point) const;
    // The place that a point with a normal stands for. Its surfel is the one that the line through it along the normal
    // meets nearest to it, among disks no farther than half their radius and patches that touch it, and facing its way.
    Departure departure(const Vec3& point, const Vec3& normal) const;
    // Throws ArgumentError where a point is so far from the scene that floats do not take it.
    void require_near(const std::vector<Vec3>& points) const;
    // Contact distance (scene/extent.h): what is no farther from the surfel touches it.
    double contact(std::uint32_t surfel) const;
    double contact(const Vec3& place) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

std::string embree_version();

}  // namespace surflux
