#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/solution/reciprocal_scaling.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Power that enters a scene and where it ends, all channels added up, by connected part: what a part lacks, no other
// part makes up for.
class PowerBalance {
public:
    // Emission that receivers find by light sampling is in no row: its loss is what is left of it, as far as senders'
    // own rays have noise; else what these say.
    explicit PowerBalance(bool emission_sampled) : emission_sampled_(emission_sampled) {}

    struct Surfel {
        double area;
        Rgb reflectance, emission, direct, irradiance;
        double from_emitters;  // part of the irradiance, where emission is sampled; all channels added up
        HemisphereLoss loss;
        double lost_scale;  // of what is reflected, by reciprocity
    };
    void add(std::uint32_t part, const Surfel& surfel);
    void operator+=(const PowerBalance& other);

    // power_in, power_absorbed, power_escaped, power_into_backs, power_lost (what is left, of either sign), parts, and
    // largest_part_lost: of the part that balances worst, what it loses or makes of what enters it.
    Figures figures() const;

private:
    struct Flux {
        double entered = 0.0, absorbed = 0.0, escaped = 0.0, into_backs = 0.0;
        // Of emission that is sampled: all, what arrives, what own rays say is lost, and how well they know.
        double emitted = 0.0, arrived = 0.0, emission_escaped = 0.0, emission_into_backs = 0.0;
        double doubt = 0.0, variance = 0.0;
        void settle_emission();
        void operator+=(const Flux& other);
        double lost() const { return entered - absorbed - escaped - into_backs; }
    };
    bool emission_sampled_;
    std::vector<Flux> parts_;
};

}  // namespace surflux
