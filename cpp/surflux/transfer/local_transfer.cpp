#include "surflux/transfer/local_transfer.h"

#include <algorithm>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/transfer/group_light.h"

namespace surflux {

namespace {

constexpr double negligible = 1e-3;  // of all the light that is sent: what another bounce would bring
constexpr int most_bounces = 1000;

}  // namespace

LocalTransfer::LocalTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, Figures timings)
    : scene_(std::move(scene)),
      operator_(std::move(transport)),
      timings_(std::move(timings)),
      points_(scene_->scene().surfels) {
    const Surfels& s = scene_->scene().surfels;
    reflectance_ = operator_.senders.means(s.reflectance, operator_.areas);
    emission_ = operator_.senders.means(s.emission, operator_.areas);
}

std::vector<Rgb> LocalTransfer::direct(const std::vector<Light>& lights, const DirectOptions& options,
                                       std::uint64_t seed, const Progress& progress) const {
    const Scene& scene = scene_->scene();
    return direct_irradiance(scene, lights, scene_->tracer(), points_, places_of(scene.surfels), options, seed,
                             progress);
}

std::vector<Rgb> LocalTransfer::indirect(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance,
                                         const RelightOptions& options) const {
    const SenderGroups& senders = operator_.senders;
    const std::vector<float> own = reflectance.empty() ? reflectance_ : senders.means(reflectance, operator_.areas);
    const auto power = [&](const std::vector<float>& sent) {
        double sum = 0.0;
        for (const std::uint32_t leaf : senders.leaves)
            for (std::size_t c = 0; c < 3; ++c)
                sum += static_cast<double>(senders.nodes[leaf].area) * static_cast<double>(sent[3 * leaf + c]);
        return sum;
    };
    // What is sent after so many reflections: what is emitted after none, what lamps bring after the first.
    std::vector<float> sent = emission_, all = emission_, received(sent.size(), 0.0f), values, coefs;
    bool is_dark = power(sent) == 0.0;
    for (int bounce = 1; bounce <= (options.bounces < 0 ? most_bounces : options.bounces); ++bounce) {
        if (!is_dark) {
            senders.pull_up(sent, 3);
            operator_.gather(sent, 3, values);
            operator_.coefficients(values, 3, coefs);
            operator_.receive(coefs, 3, received);
        }
        if (bounce == 1) {
            const GroupLight direct(*scene_, senders, operator_.samples);
            const std::vector<float> lit = direct.irradiance(lights, own, {options.shadow_rays, options.seed});
            for (std::size_t k = 0; k < lit.size(); ++k) received[k] += lit[k];
        }
        for (std::size_t k = 0; k < sent.size(); ++k) {
            sent[k] = own[k] * received[k];
            all[k] += sent[k];
        }
        is_dark = power(sent) == 0.0;
        if (is_dark || (options.bounces < 0 && power(sent) <= negligible * power(all))) break;
    }
    senders.pull_up(all, 3);
    operator_.gather_tilted(all, values);
    operator_.coefficients(values, 3 * TransportOperator::tilted_channels, coefs);
    const Surfels& s = scene_->scene().surfels;
    std::vector<Rgb> out(s.size());
    operator_.at_surfels.multiply(coefs, 3 * TransportOperator::tilted_channels, [&](std::size_t i, const float* sum) {
        const Vec3& n = s.normals[i];
        for (int c = 0; c < 3; ++c)
            out[i][c] =
                std::max(0.0, static_cast<double>(sum[c]) + n.x * static_cast<double>(sum[3 + c]) +
                                  n.y * static_cast<double>(sum[6 + c]) + n.z * static_cast<double>(sum[9 + c]));
    });
    return out;
}

}  // namespace surflux
