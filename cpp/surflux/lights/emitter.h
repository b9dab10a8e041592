#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/lights/sample_points.h"
#include "surflux/scene/lights.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// The surfel that is lit, as far as a light needs to know it.
struct Receiver {
    const SurfelPoints& points;
    std::uint32_t surfel, shape;
    Vec3 center, normal;
    bool is_whole_surfel;

    bool is_patch() const { return shape != Place::point && points.is_patch(shape); }
    Vec3 at(double s, double t) const { return is_patch() ? points.at(shape, s, t) : center; }
};

// Of surfels that are near each other: no normal differs from `axis` by more than `spread`, and `center` is no higher
// than `height` over the plane of any.
struct NormalCone {
    Vec3 center, axis;
    double spread = 0.0, height = 0.0;

    // Does a point lie behind all of them?
    bool is_behind(const Vec3& point) const {
        const Vec3 d = point - center;
        return dot(axis, d) + spread * length(d) + height < 0.0;
    }
};

// What one point of a light sends to one point of a surfel.
struct Arrival {
    Vec3 from;            // where the shadow ray ends; the direction to the light where it is distant
    double kernel = 0.0;  // irradiance per unit of colour, unoccluded
};

struct Emitter {
    virtual ~Emitter() = default;
    // From the light's point (s, t): evenly over its area or, close to what is wide, over its solid angle. The mean
    // over all is kernel_at().
    virtual Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const = 0;
    // Mean of the kernel over the light, at one place.
    virtual double kernel_at(const Vec3& point, const Vec3& normal) const = 0;
    // The same of several places.
    virtual void kernels_at(const Vec3* points, const Vec3* normals, std::size_t count, double* out) const {
        for (std::size_t k = 0; k < count; ++k) out[k] = kernel_at(points[k], normals[k]);
    }
    // Mean of the kernel over the light and over the receiver.
    virtual double mean_kernel(const Receiver& receiver) const = 0;
    // Do few points of what lies within a sphere tell its mean kernel? Not close to the light, nor in a narrow beam.
    virtual bool is_even_in(const Vec3& center, double radius) const = 0;
    // Do surfels all face away from it?
    virtual bool is_behind(const NormalCone& surfels) const = 0;
    // Is the light so wide beside its distance that few points of its area tell little of kernel_at()?
    virtual bool is_wide_at(const Vec3&) const { return false; }
    // Of a patch, the part that the light can shine on, where that may be little of it; else nothing.
    virtual void find_lit(const Receiver&, std::vector<Triangle>&) const {}
    Rgb color;
    bool distant = false;
    bool extended = false;  // more than one point
    std::size_t index = 0;  // in the scene's lights
};

// Those of lights that are no Environments.
std::vector<std::unique_ptr<Emitter>> emitters_of(const std::vector<Light>& lights);

}  // namespace surflux
