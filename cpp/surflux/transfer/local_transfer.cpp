#include "surflux/transfer/local_transfer.h"

#include <algorithm>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/transfer/tilted_light.h"

namespace surflux {

LocalTransfer::LocalTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, Figures timings)
    : scene_(std::move(scene)),
      operator_(std::move(transport)),
      timings_(std::move(timings)),
      points_(scene_->scene().surfels),
      light_(*scene_, operator_.senders, operator_.samples, points_, operator_.areas),
      reflectance_(operator_.senders.means(scene_->scene().surfels.reflectance, operator_.areas)),
      emitted_(*scene_, operator_) {}

std::vector<Rgb> LocalTransfer::direct(const std::vector<Light>& lights, const DirectOptions& options,
                                       std::uint64_t seed, const Progress& progress) const {
    const Scene& scene = scene_->scene();
    return direct_irradiance(scene, lights, scene_->tracer(), points_, places_of(scene.surfels), options, seed,
                             progress);
}

std::vector<Rgb> LocalTransfer::indirect(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance,
                                         const RelightOptions& options) const {
    const SenderGroups& senders = operator_.senders;
    const std::vector<float> other =
        reflectance.empty() ? std::vector<float>() : senders.means(reflectance, operator_.areas);
    const std::vector<float>& own = reflectance.empty() ? reflectance_ : other;
    std::vector<float> direct;  // of no bounces nothing asks for it
    if (options.bounces != 0) {
        direct = light_.irradiance(lights, own, {options.shadow_rays, options.seed});
        emitted_.add_at_leaves(direct);
    }
    const std::vector<float> all =
        sent_after(options.bounces, operator_, connected_, colors, emitted_.sent(), own, direct);
    const Scratch<Tilted>::Lent tilted(tilted_);
    std::vector<float>&values = (*tilted).values, &coefs = (*tilted).coefs;
    operator_.gather_tilted(all, values);
    operator_.coefficients(values, TransportOperator::tilted_channels, coefs);
    const Surfels& s = scene_->scene().surfels;
    std::vector<Rgb> out(s.size());
    parallel_blocks(s.size(), 512, [&](std::size_t begin, std::size_t end) {
        irradiance_at_rows(operator_.at_surfels, s.normals, coefs.data(), begin, end, out.data());
    });
    const std::vector<Rgb>& emitted = emitted_.at_surfels();
    for (std::size_t i = 0; i < emitted.size(); ++i) out[i] += emitted[i];
    return out;
}

}  // namespace surflux
