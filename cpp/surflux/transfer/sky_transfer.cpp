#include "surflux/transfer/sky_transfer.h"

#include <algorithm>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t at_once = 16;  // patches, whose coefficients are found together

}  // namespace

SkyTransfer::SkyTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, SkyPatches patches,
                         SkyIrradiance direct, Figures timings)
    : scene_(std::move(scene)),
      operator_(std::move(transport)),
      patches_(std::move(patches)),
      direct_(std::move(direct)),
      timings_(std::move(timings)),
      reflectance_(operator_.senders.means(scene_->scene().surfels.reflectance, operator_.areas)),
      emitted_(*scene_, operator_) {
    direct_.require_whole(operator_.rows.size(), patches_.size());
}

SkyTransfer::Fields SkyTransfer::fields(const std::vector<float>& radiances, std::size_t channels,
                                        const std::vector<float>& besides, const std::vector<float>& emission,
                                        const std::vector<float>& reflectance, int bounces) const {
    std::vector<float> direct, reflected, received;
    direct_.receive(radiances, channels, direct);
    Fields out;
    operator_.coefficients(direct, channels, out.direct);
    operator_.receive(out.direct, channels, received);
    for (std::size_t k = 0; k < besides.size(); ++k) received[k] += besides[k];
    const std::vector<float> sent =
        sent_after(bounces, operator_, connected_, channels, emission, reflectance, received);
    operator_.gather(sent, channels, reflected);
    for (std::size_t k = 0; k < direct.size(); ++k) reflected[k] += direct[k];
    operator_.coefficients(reflected, channels, out.all);
    return out;
}

std::vector<Rgb> SkyTransfer::sunlight(const std::vector<Light>& lights, const DirectOptions& options,
                                       std::uint64_t seed, const Progress& progress) const {
    const Scene& scene = scene_->scene();
    const SurfelPoints points(scene.surfels);
    return direct_irradiance(scene, lights, scene_->tracer(), points, places_of(scene.surfels), options, seed,
                             progress);
}

SkyTransfer::Irradiance SkyTransfer::irradiance(const std::vector<Rgb>& radiances, const std::vector<Rgb>& sun,
                                                const std::vector<Rgb>& reflectance, int bounces) const {
    const SenderGroups& senders = operator_.senders;
    std::vector<float> sky;
    for (const Rgb& radiance : radiances) {
        for (int c = 0; c < 3; ++c) sky.push_back(static_cast<float>(radiance[c]));
        sky.push_back(0.0f);
    }
    std::vector<float> besides(emitted_.sent().size(), 0.0f);
    if (!sun.empty()) besides = senders.means(sun, operator_.areas);
    emitted_.add_at_leaves(besides);
    const Fields found =
        fields(sky, colors, besides, emitted_.sent(),
               reflectance.empty() ? reflectance_ : senders.means(reflectance, operator_.areas), bounces);
    // The basis runs below 0 where light changes steeply: what it takes off the sky's light does not come off what is
    // reflected.
    Irradiance out{at_surfels(found.direct), at_surfels(found.all)};
    for (std::size_t i = 0; i < out.all.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double reflected = std::max(0.0, out.all[i][c] - out.direct[i][c]);
            out.direct[i][c] = std::max(0.0, out.direct[i][c]);
            out.all[i][c] = out.direct[i][c] + reflected;
        }
    for (std::size_t i = 0; i < sun.size(); ++i) out.direct[i] += sun[i], out.all[i] += sun[i];
    const std::vector<Rgb>& emitted = emitted_.at_surfels();
    for (std::size_t i = 0; i < emitted.size(); ++i) out.all[i] += emitted[i];
    return out;
}

std::vector<Rgb> SkyTransfer::at_surfels(const std::vector<float>& coefs) const {
    std::vector<Rgb> out(operator_.areas.size());
    operator_.at_surfels.multiply(coefs, colors, [&](std::size_t i, const float* sum) {
        for (int c = 0; c < 3; ++c) out[i][c] = static_cast<double>(sum[c]);
    });
    return out;
}

std::vector<float> SkyTransfer::coefficients(const std::vector<std::uint32_t>& surfels, int bounces,
                                             const Progress& progress) const {
    const std::size_t patches = patches_.size(), channels = colors * at_once;
    const std::vector<float> none(operator_.senders.size() * channels, 0.0f);
    const SparseRows& at = operator_.at_surfels;
    std::vector<float> out(surfels.size() * patches * 3);
    for (std::size_t first = 0; first < patches; first += at_once) {
        report(progress, first, patches);
        const std::size_t count = std::min(at_once, patches - first);
        std::vector<float> sky(patches * channels, 0.0f);
        for (std::size_t p = 0; p < count; ++p) std::fill_n(sky.data() + (first + p) * channels + p * colors, 3, 1.0f);
        const std::vector<float> coefs = fields(sky, channels, {}, none, reflectance_, bounces).all;
        parallel_for(surfels.size(), 64, [&](std::size_t k) {
            float* to = out.data() + (k * patches + first) * 3;
            for (std::uint32_t e = at.begin[surfels[k]]; e < at.begin[surfels[k] + 1]; ++e)
                for (std::size_t c = 0; c < 3 * count; ++c)
                    to[c] += at.entries[e].weight * coefs[at.entries[e].column * channels + c / 3 * colors + c % 3];
        });
    }
    return out;
}

}  // namespace surflux
