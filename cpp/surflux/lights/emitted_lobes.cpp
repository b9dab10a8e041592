#include "surflux/lights/emitted_lobes.h"

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_rays.h"

namespace surflux {

std::vector<Rgb> emitted_lobes(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                               const std::vector<Place>& places, const std::vector<GlossyLobe>& lobes, int samples,
                               std::uint64_t seed) {
    std::vector<Rgb> out(places.size());
    parallel_blocks(places.size(), 16, [&](std::size_t begin, std::size_t end) {
        LightRays towards;
        std::vector<Rgb> brought;
        std::vector<Ray> along;
        std::vector<Hit> hits;
        for (std::size_t i = begin; i < end; ++i) {
            const Place& place = places[i];
            const GlossyLobe& lobe = lobes[i];
            EvenPoints even(4, seed, stream_of(place));
            Random random(seed, stream_of(place));
            towards.clear(), brought.clear(), along.clear();
            for (int k = 0; k < samples; ++k) {
                const double* u = even.next();
                const double choice = random.uniform(), across = random.uniform(), along_it = random.uniform();
                const Departure at{points.at(place, across, along_it), place.normal, place.surfel};
                const LightRay light = lights.sample(at.position, lobe, u[2], u[3], choice);
                if (light.length > 0.0 && !(light.irradiance == Rgb{})) {
                    towards.add(at, light);
                    brought.push_back(light.irradiance);
                }
                const Vec3 direction = lobe.sample(u[0], u[1], 0.0);
                if (dot(place.normal, direction) > 0.0) along.push_back({at, direction});
            }
            const std::vector<char>& arrives = towards.trace(tracer);
            tracer.closest(along, hits);
            for (std::size_t k = 0; k < brought.size(); ++k)
                if (arrives[k] != 0) out[i] += brought[k];
            for (std::size_t k = 0; k < along.size(); ++k)
                out[i] += lights.found(along[k].from.position, lobe, along[k].direction, hits[k]);
            out[i] = out[i] / samples;
        }
    });
    return out;
}

}  // namespace surflux
