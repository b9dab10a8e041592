#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/light_sampler.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Light samples of many places, traced together. Those of lamps and of the sky are shadow rays, which end just short of
// the lamp: the surface in whose plane it lies does not block it. Those of surfels arrive where they meet the front of
// the surfel first.
class LightRays {
public:
    void clear();
    void add(const Departure& from, const LightRay& light);
    std::size_t size() const { return samples_.size(); }
    // Of each, in the order in which they were added: does it arrive?
    const std::vector<char>& trace(const Tracer& tracer);

private:
    struct Sample {
        std::uint32_t target, ray;  // of shadow_, or of towards_ where there is a target
    };
    std::vector<Sample> samples_;
    std::vector<Ray> shadow_, towards_;
    std::vector<char> free_, arrives_;
    std::vector<Hit> hits_;
};

}  // namespace surflux
