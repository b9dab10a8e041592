#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Named figures in the order in which they came up.
using Figures = std::vector<std::pair<std::string, double>>;
// One of them, at first 0.
inline double& figure(Figures& figures, const std::string& name) {
    for (auto& [known, value] : figures)
        if (known == name) return value;
    return figures.emplace_back(name, 0.0).second;
}

// What every solver gives: H and B = E + rho H per surfel, and how they came about.
struct Solution {
    Surfels surfels;
    std::vector<std::uint32_t> parents;  // of each surfel, its index in the scene
    std::vector<std::int32_t> levels;    // of what light was gathered for (see Solution.levels in Python)
    std::vector<std::uint32_t> cut;      // of each surfel, the node of the last cut above it; empty where all pairs
                                         // of surfels, or no surfels, exchanged light
    std::vector<Rgb> radiosity;          // B, exitance
    std::vector<Rgb> irradiance;         // H
    std::vector<Rgb> direct;             // the part of H from lights and Environments alone
    std::vector<Rgb> emitted;            // that from small emissive surfels (LightSampler) alone; empty without them
    double error = 0.0;                  // the solver's own estimate of the relative RMS error of H; NaN where H is 0
    Figures timings;                     // stage, seconds
    std::vector<Figures> history;        // per iteration
};

}  // namespace surflux
