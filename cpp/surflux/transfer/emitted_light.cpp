#include "surflux/transfer/emitted_light.h"

#include "surflux/lights/emitted_lobes.h"
#include "surflux/lights/light_sampled_irradiance.h"

namespace surflux {

namespace {

constexpr int probes = 64, rays = 256;  // of each surfel, as `solve` by rays has them
constexpr int lobe_samples = 32;
constexpr std::uint64_t seed = 0;  // a transfer from a file has the same light

}  // namespace

EmittedLight::EmittedLight(const CompiledScene& scene, const TransportOperator& transport)
    : scene_(scene), operator_(transport) {
    const LightSampler emitters = LightSampler::of_surfels(scene.scene());
    const Surfels& s = scene.scene().surfels;
    std::vector<Rgb> others(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i)
        if (!emitters.samples(i)) others[i] = s.emission[i];
    any_sampled_ = !emitters.empty();
    sent_ = operator_.senders.means(others, operator_.areas);
}

void EmittedLight::find() const {
    const Scene& scene = scene_.scene();
    at_surfels_ = emitted_irradiance(scene_.tracer(), LightSampler::of_surfels(scene), SurfelPoints(scene.surfels),
                                     places_of(scene.surfels), {probes, rays}, seed);
    at_leaves_ = operator_.senders.means(at_surfels_, operator_.areas);
}

const std::vector<Rgb>& EmittedLight::at_surfels() const {
    if (any_sampled_) std::call_once(once_, [&] { find(); });
    return at_surfels_;
}

std::vector<Rgb> EmittedLight::mirrored(const std::vector<Place>& places, const std::vector<GlossyLobe>& lobes) const {
    const Scene& scene = scene_.scene();
    return emitted_lobes(scene_.tracer(), LightSampler::of_surfels(scene), SurfelPoints(scene.surfels), places, lobes,
                         lobe_samples, seed);
}

void EmittedLight::add_at_leaves(std::vector<float>& direct) const {
    if (at_surfels().empty()) return;
    for (std::size_t k = 0; k < direct.size(); ++k) direct[k] += at_leaves_[k];
}

}  // namespace surflux
