#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/tuning.h"

namespace surflux {

// Irradiance on surfaces as a sum of basis functions (L07 eq. 9), whose finer levels LevelLight limits where it is
// asked for at a place: a multilevel basis and a coefficient for each function.
struct MeshlessField {
    struct At {
        Rgb all, direct;
        void clamp();  // light is never negative, which sums of coefficients may be by a little
    };

    MultilevelBasis basis;
    std::vector<Rgb> coefficients;  // of all that the basis holds
    std::vector<Rgb> direct;        // of the part that lights and Environments bring directly
    std::vector<char> gathered;     // of each function: does it have a coefficient?
    std::vector<At> values;         // what was gathered at the point of each that does
    double largest_deviation = MeshlessTuning{}.largest_deviation, largest_part = MeshlessTuning{}.largest_part;

    At at(const Vec3& point, const Vec3& normal, std::uint32_t object) const;
    // The same from functions that the place sees. False where it sees none of the coarsest.
    bool at(const Vec3& point, const Vec3& normal, std::uint32_t object, const BasisSight& sight, At& out) const;
    // The finest level on which light was gathered for a function that is not zero there; 0 where none was.
    std::int32_t level_at(const Vec3& point, const Vec3& normal, std::uint32_t object) const;
};

}  // namespace surflux
