#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Power that enters a scene and where it ends, all channels added up, by connected part: what a part lacks, no other
// part makes up for.
class PowerBalance {
public:
    struct Flux {
        double entered = 0.0, absorbed = 0.0, escaped = 0.0, into_backs = 0.0;
        double lost() const { return entered - absorbed - escaped - into_backs; }
        void operator+=(const Flux& other);
    };
    struct Surfel {
        double area;
        Rgb reflectance, emission, direct, irradiance;
        double escape, into_backs;  // shares of its hemisphere
    };
    void add(std::uint32_t part, const Surfel& surfel);

    // power_in, power_absorbed, power_escaped, power_into_backs, power_lost (what is left, of either sign), parts, and
    // largest_part_lost: of the part that balances worst, what it loses or makes of what enters it.
    Figures figures() const;

private:
    std::vector<Flux> parts_;
};

}  // namespace surflux
