#include "surflux/transfer/distant_transfer.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/transfer/harmonic_lobe.h"
#include "surflux/transfer/harmonic_product.h"
#include "surflux/transfer/sky_visibility.h"

namespace surflux {

namespace {

constexpr std::uint64_t visibility_stream = 0x5f70;
constexpr std::size_t block = 64;  // of rows, that are multiplied together
constexpr std::size_t seen = SphericalHarmonics::count(DistantTransfer::visibility_order);
constexpr std::size_t distant = IncidentLight::distant, reflected = IncidentLight::reflected;
constexpr float finest = 32767.0f;

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Harmonics of reflected radiance that comes along the links of rows.
class ReflectedLight {
public:
    explicit ReflectedLight(const TransportOperator& transport) : transport_(transport), basis_(order) {}

    // Into 3 reflected. Each ray of a link stands for pi / cos of solid angle, all of them for a cap around their mean;
    // below the horizon as in the mirror. What that is off by in irradiance, which the rays are distributed for, is put
    // right by even light.
    void gather(std::size_t k, const std::vector<float>& sent, double* out) const {
        const TransportOperator::Row& row = transport_.rows[k];
        const Frame frame = frame_around(transport_.normals[k]);
        double above[reflected], below[reflected], cap[order];
        std::fill_n(out, 3 * reflected, 0.0);
        Rgb irradiance;
        for (std::uint32_t l = row.begin; l < row.end; ++l) {
            const TransportOperator::Link link = transport_.links[l];
            const TransportOperator::Slope slope = transport_.slopes[l];
            const Vec3 local = normalized({static_cast<double>(slope.u), static_cast<double>(slope.v),
                                           static_cast<double>(ShotRows::slope_scale)});
            basis_.evaluate(frame.to_world(local), above);
            basis_.evaluate(frame.to_world({local.x, local.y, -local.z}), below);
            const double share = static_cast<double>(row.per_ray * TransportOperator::rays_of(link));
            cap_bands(pi * share / local.z, order, cap);
            scale_bands(cap, order, above);
            scale_bands(cap, order, below);
            for (std::size_t c = 0; c < 3; ++c) {
                const auto arrived = share * static_cast<double>(sent[colors * TransportOperator::sender(link) + c]);
                irradiance[static_cast<int>(c)] += arrived;
                for (std::size_t i = 0; i < reflected; ++i) out[3 * i + c] += arrived / local.z * (above[i] + below[i]);
            }
        }
        basis_.evaluate(transport_.normals[k], above);
        scale_bands(cosine_, above);
        for (std::size_t c = 0; c < 3; ++c) {
            double found = 0.0;
            for (std::size_t i = 0; i < reflected; ++i) found += above[i] * out[3 * i + c];
            out[c] += (irradiance[static_cast<int>(c)] - found) / above[0];
        }
    }

private:
    static constexpr int order = IncidentLight::reflected_order;
    const TransportOperator& transport_;
    SphericalHarmonics basis_;
    std::vector<double> cosine_ = lobe_bands(1.0, order);
};

}  // namespace

DistantTransfer::DistantTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport,
                                 Visibility visibility, Figures timings)
    : scene_(std::move(scene)),
      operator_(std::make_shared<const TransportOperator>(std::move(transport))),
      timings_(std::move(timings)),
      visibility_(std::move(visibility)) {
    const std::size_t rows = operator_->rows.size();
    require(visibility_.values.size() == rows * seen && visibility_.scale.size() == rows, "visibility: wanted ", seen,
            " harmonics of each of ", rows, " rows");
    for (const float scale : visibility_.scale)
        require(std::isfinite(scale) && scale >= 0.0f, "visibility_scale: wanted finite numbers");
    reflectance_ = operator_->senders.means(scene_->scene().surfels.reflectance, operator_->areas);
    emitted_ = std::make_shared<const EmittedLight>(*scene_, *operator_);
}

DistantTransfer::Visibility find_visibility(const TransportOperator& transport, const SurfelPoints& points,
                                            const Tracer& tracer, int rays, std::uint64_t seed,
                                            const Progress& progress, const Team& team) {
    const std::size_t rows = transport.rows.size();
    DistantTransfer::Visibility out{std::vector<std::int16_t>(rows * seen), std::vector<float>(rows)};
    const SkyVisibility sky(points, tracer, DistantTransfer::visibility_order, seed + visibility_stream);
    shared_blocks(
        team, "visibility", [&] { return digest_of(seed, transport.positions); }, rows, 16,
        [&](std::size_t begin, std::size_t end) {
            SkyVisibility::Scratch scratch;
            std::vector<float> values(seen);
            for (std::size_t k = begin; k < end; ++k) {
                sky.find(transport.place(k), rays, scratch, values.data());
                float most = 0.0f;
                for (const float v : values) most = std::max(most, std::abs(v));
                out.scale[k] = most / finest;
                for (std::size_t i = 0; i < seen && most > 0.0f; ++i)
                    out.values[k * seen + i] = static_cast<std::int16_t>(std::lround(values[i] / out.scale[k]));
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            to.add(out.scale.data() + begin, end - begin);
            to.add(out.values.data() + begin * seen, (end - begin) * seen);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            from.take(out.scale.data() + begin, end - begin);
            from.take(out.values.data() + begin * seen, (end - begin) * seen);
        },
        progress);
    return out;
}

IncidentLight DistantTransfer::incident(const std::vector<Rgb>& environment, const std::vector<Rgb>& reflectance,
                                        int bounces) const {
    constexpr std::size_t channels = IncidentLight::channels;
    const SenderGroups& senders = operator_->senders;
    const std::size_t rows = operator_->rows.size();
    // "Times the environment", for the visibility of a row to be multiplied by.
    const HarmonicProduct product(source_order, visibility_order, IncidentLight::distant_order);
    Matrix times[3];
    for (int c = 0; c < 3; ++c) {
        std::vector<double> of_color;
        for (const Rgb& coefficient : environment) of_color.push_back(coefficient[c]);
        const std::vector<double> matrix = product.matrix(of_color.data());
        times[c] = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
                       matrix.data(), distant, seen)
                       .cast<float>();
    }
    const SphericalHarmonics cosine_basis(IncidentLight::distant_order);
    const ReflectedLight reflections(*operator_);
    const std::vector<double> cosine = lobe_bands(1.0, IncidentLight::distant_order);
    std::vector<float> light(rows * channels), irradiance(colors * rows, 0.0f);
    parallel_blocks(rows, block, [&](std::size_t begin, std::size_t end) {
        const auto count = static_cast<Eigen::Index>(end - begin);
        Matrix visible(static_cast<Eigen::Index>(seen), count);
        for (std::size_t k = begin; k < end; ++k)
            for (std::size_t i = 0; i < seen; ++i)
                visible(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k - begin)) =
                    visibility_.scale[k] * static_cast<float>(visibility_.values[k * seen + i]);
        for (std::size_t c = 0; c < 3; ++c) {
            const Matrix found = times[c] * visible;
            for (std::size_t k = begin; k < end; ++k)
                for (std::size_t i = 0; i < distant; ++i)
                    light[k * channels + 3 * i + c] =
                        found(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k - begin));
        }
        double at[distant];
        for (std::size_t k = begin; k < end; ++k) {
            cosine_basis.evaluate(operator_->normals[k], at);
            scale_bands(cosine, at);
            for (std::size_t c = 0; c < 3; ++c) {
                double sum = 0.0;
                for (std::size_t i = 0; i < distant; ++i)
                    sum += at[i] * static_cast<double>(light[k * channels + 3 * i + c]);
                irradiance[colors * k + c] = static_cast<float>(sum);
            }
        }
    });
    std::vector<float> coefs, direct;
    operator_->coefficients(irradiance, colors, coefs);
    operator_->receive(coefs, colors, direct);
    emitted_->add_at_leaves(direct);
    const std::vector<float> own = reflectance.empty() ? reflectance_ : senders.means(reflectance, operator_->areas);
    const std::vector<float> sent = sent_after(bounces, *operator_, connected_, colors, emitted_->sent(), own, direct);
    parallel_blocks(rows, block, [&](std::size_t begin, std::size_t end) {
        double found[3 * reflected];
        for (std::size_t k = begin; k < end; ++k) {
            reflections.gather(k, sent, found);
            float* to = light.data() + k * channels + 3 * distant;
            for (std::size_t i = 0; i < 3 * reflected; ++i) to[i] = static_cast<float>(found[i]);
        }
    });
    operator_->coefficients(light, channels, coefs);
    return {scene_, operator_, emitted_, std::move(coefs)};
}

std::size_t DistantTransfer::bytes() const {
    return operator_->bytes() + visibility_.values.size() * sizeof visibility_.values[0] +
           visibility_.scale.size() * sizeof visibility_.scale[0];
}

}  // namespace surflux
