#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "surflux/lights/aimed_row.h"
#include "surflux/lights/light_rays.h"
#include "surflux/meshless/hemisphere_gather.h"

namespace surflux {

// What rays of one place have found so far. Of shares of functions most are 0.
class HemisphereGather::Sums {
public:
    void make_room(std::size_t functions) { sums_.resize(functions); }
    void add(std::uint32_t function, double weight, const float (&share)[3]) {
        Sum& sum = sums_[function];
        if (!sum.touched) {
            sum.touched = true;
            touched_.push_back(function);
        }
        for (int c = 0; c < 3; ++c) sum.share[c] += weight * static_cast<double>(share[c]);
    }
    // Appends them by function, and begins anew.
    void take(std::vector<Link>& out) {
        std::sort(touched_.begin(), touched_.end());
        out.reserve(out.size() + touched_.size());
        for (const std::uint32_t function : touched_) {
            Sum& sum = sums_[function];
            out.push_back({function,
                           {static_cast<float>(sum.share[0]), static_cast<float>(sum.share[1]),
                            static_cast<float>(sum.share[2])}});
            sum = {};
        }
        touched_.clear();
    }

    // Rays of the hemisphere of a place, over all of it, were it as dense as it is in this direction.
    double density(const Vec3& direction) const {
        return aimed.density.empty() ? static_cast<double>(aimed.found.rays.size())
                                     : aimed.density_towards(frame, direction);
    }

    std::vector<BasisWeight> weights;
    AimedRow aimed;  // evenly spread rays are `found` alone
    Frame frame;
    std::vector<Hit> hits;  // of rays that are not over the hemisphere of the place
    // Of light that a surfel reflects, if it arrives there.
    struct Gain {
        std::uint32_t surfel;
        Rgb of;
        bool second_half;
    };
    std::vector<LightRay> of_lights;
    LightRays towards;
    std::vector<Gain> gain;
    std::vector<Ray> ahead;  // over the hemisphere of what is lit, for SurfaceLight::found()
    std::vector<Gain> ahead_gain;
    // A sample of a lit patch, and the share of what it reflects that it brings.
    struct LitSample {
        LitPatches::Target at;
        double distance, density;
        Rgb gain;
        bool second_half;
    };
    LitPatches::Aim aim;
    std::vector<LitSample> lit_samples;
    std::vector<Ray> lit_rays;
    // What has been found of light that needs no solving: the first bounce, and by halves of the rays.
    Rgb first, halves[2];
    std::vector<Lit> lit;
    void add_first(std::uint32_t surfel, const Rgb& found, bool in_second_half) {
        first += found;
        halves[in_second_half] += found;
        if (!(found == Rgb{})) lit.push_back({surfel, static_cast<float>(luminance(found))});
    }
    // Those of one surfel together, in order.
    void take_lit(std::vector<Lit>& out) {
        std::stable_sort(lit.begin(), lit.end(), [](const Lit& a, const Lit& b) { return a.surfel < b.surfel; });
        std::size_t count = 0;
        for (const Lit& of : lit) {
            if (count > 0 && lit[count - 1].surfel == of.surfel)
                lit[count - 1].luminance += of.luminance;
            else
                lit[count++] = of;
        }
        out.assign(lit.begin(), lit.begin() + static_cast<std::ptrdiff_t>(count));
    }

private:
    struct Sum {
        double share[3] = {};
        bool touched = false;
    };
    std::vector<Sum> sums_;
    std::vector<std::uint32_t> touched_;
};

}  // namespace surflux
