#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/aimed_row.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Particles of light from all that sends to what they meet (Pattanaik and Mudur 1992). In a dim room rays of few nodes
// find the gap through which its light comes, and where those of none do, nodes around cannot tell them: particles
// arrive by what light there is. They are evidence, and none of it becomes light.
class LightParticles {
public:
    explicit LightParticles(const RefinementTuning& tuning = {}) : tuning_(tuning) {}

    // As many as there are surfels, times so many, within bounds. `sent` of all nodes, `channels` interleaved.
    void shoot(const SurfelTree& tree, const Tracer& tracer, const std::vector<double>& sent, std::size_t channels,
               std::uint64_t seed, const Progress& progress);
    bool empty() const { return arrivals_.empty(); }

    // Of the nodes of a cut: irradiance (its luminance) by those that arrived, where these are enough to tell; else 0.
    std::vector<double> irradiance(const SurfelTree& tree, const Cut& cut) const;
    // Where those come from that arrived at a node, as seen from a place; more than some are left out.
    void aims_of(std::uint32_t node, const SurfelTree& tree, const Vec3& at, std::vector<Aim>& out) const;

private:
    RefinementTuning tuning_;
    struct Arrival {
        std::uint32_t surfel, sender;
        float light;  // that the sender sends, its luminance
    };
    std::vector<Arrival> arrivals_;     // by surfel
    std::vector<std::uint32_t> begin_;  // of each point, and one more
    double power_ = 0.0;                // of each particle
};

}  // namespace surflux
