#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/lights/sky_patches.h"

namespace surflux {

// Directions into every patch of the sky and into the ground, and what light the patches bring where rays that way are
// free. What an open patch brings is integrated, and the rays say which share of that arrives; so it is exact where a
// patch is open, or hidden.
class PatchRays {
public:
    // `of_patch` directions in each patch of the sky, shifted all alike by the seed. Along a row they go up and down by
    // the golden ratio, and rows are turned by van der Corput's sequence: in streets that run anywhere one in each of
    // 577 patches is off by .5 % of the sky (RMS), where random places are by .7 and the middles by .9.
    PatchRays(const SkyPatches& patches, std::size_t of_patch, std::uint64_t seed);

    const std::vector<Vec3>& directions() const { return directions_; }
    std::size_t patches() const { return patches_.size(); }  // the ground included
    // Irradiance of planes by each patch alone, where its radiance is 1: (normals, patches), the ground's first.
    // `bits`: a row for each normal, as FreeDirections has them for directions().
    std::vector<double> coefficients(const std::vector<Vec3>& normals, const std::uint8_t* bits) const;

private:
    struct Patch {
        double solid_angle;
        Vec3 middle, mean;  // mean: of all directions in it
        double sine;        // of the angle between its middle and its farthest corner
        std::size_t ray;    // the first of its directions
    };
    // What the patch brings where nothing is in the way.
    double unoccluded(std::size_t patch, const Vec3& normal) const;
    void add_row(const Vec3& normal, const std::uint8_t* bits, double* out) const;

    std::vector<Patch> patches_;
    std::vector<Vec3> directions_;
    std::vector<Vec3> parts_;  // directions that stand for equal parts of each patch of the sky
};

}  // namespace surflux
