#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/solution/reciprocal_scaling.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Power that enters a scene and where it ends, by connected part and by channel: what one lacks, no other makes up for.
// What leaves the scene or meets backs is counted from the senders' own rays, what is absorbed from the light that
// receivers have: so power_lost is what the solution lacks, or has too much, to within its standard error.
class PowerBalance {
public:
    struct Surfel {
        double area;
        Rgb reflectance, emission, direct, irradiance;
        HemisphereLoss loss;
    };
    void add(std::uint32_t part, const Surfel& surfel);
    void operator+=(const PowerBalance& other);

    // power_in, power_absorbed, power_escaped, power_into_backs, power_lost (the residual, of either sign),
    // power_lost_error (its standard error by the senders' rays), all channels added up; parts, and largest_part_lost:
    // of the part and channel that balance worst, what is lost or made of what enters.
    Figures figures() const;

private:
    struct Flux {
        Rgb entered, absorbed, escaped, into_backs;
        double variance = 0.0;  // of what is lost, all channels added up
        void operator+=(const Flux& other);
        Rgb lost() const { return entered - absorbed - escaped - into_backs; }
    };
    std::vector<Flux> parts_;
};

}  // namespace surflux
