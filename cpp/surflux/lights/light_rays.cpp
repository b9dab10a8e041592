#include "surflux/lights/light_rays.h"

namespace surflux {

void LightRays::clear() { samples_.clear(), shadow_.clear(), towards_.clear(); }

void LightRays::add(const Departure& from, const LightRay& light) {
    std::vector<Ray>& rays = light.target == Hit::none ? shadow_ : towards_;
    samples_.push_back({light.target, static_cast<std::uint32_t>(rays.size())});
    rays.push_back({from, light.direction, light.length});
}

const std::vector<char>& LightRays::trace(const Tracer& tracer) {
    tracer.free(shadow_, free_);
    tracer.closest(towards_, hits_);
    arrives_.clear();
    for (const Sample& s : samples_)
        arrives_.push_back(s.target == Hit::none ? free_[s.ray]
                                                 : hits_[s.ray].front && hits_[s.ray].surfel == s.target);
    return arrives_;
}

}  // namespace surflux
