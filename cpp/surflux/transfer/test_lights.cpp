#include "surflux/transfer/test_lights.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/transfer/group_light.h"

namespace surflux {

namespace {

constexpr std::size_t rays_of_lamp = 65536;

}  // namespace

TestLights::TestLights(const CompiledScene& compiled, const TransportOperator& of,
                       const std::vector<float>& reflectance, const std::vector<Vec3>& lamps, std::uint64_t seed,
                       const Progress& progress)
    : RowTest(lamps.size()), sent_(of.senders.size() * lamps.size(), 0.0f) {
    const GroupLight light(compiled, of.senders, of.samples);
    for (std::size_t lamp = 0; lamp < size(); ++lamp) {
        report(progress, lamp, size());
        const std::vector<float> direct =
            light.irradiance({PointLight{lamps[lamp], {1.0, 1.0, 1.0}}}, reflectance, {rays_of_lamp, seed});
        for (const std::uint32_t leaf : of.senders.leaves) {
            const Rgb reflected{static_cast<double>(reflectance[3 * leaf]),
                                static_cast<double>(reflectance[3 * leaf + 1]),
                                static_cast<double>(reflectance[3 * leaf + 2])};
            sent_[leaf * size() + lamp] = static_cast<float>(luminance(reflected)) * direct[3 * leaf];
        }
    }
    of.senders.pull_up(sent_, size());
}

void TestLights::receive(const TransportOperator& of, Received& out) const {
    const std::size_t from = out.variance.size(), n = size();
    out.values.resize(of.rows.size() * n, 0.0f);
    out.variance.resize(of.rows.size(), 0.0f);
    parallel_blocks(of.rows.size() - from, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<float> halves(2 * n);
        for (std::size_t k = from + begin; k < from + end; ++k) {
            const TransportOperator::Row& row = of.rows[k];
            std::fill(halves.begin(), halves.end(), 0.0f);
            for (std::uint32_t l = row.begin; l < row.end; ++l) {
                const TransportOperator::Link& link = of.links[l];
                const float* sent = sent_.data() + link.sender * n;
                const auto first = static_cast<float>(link.first), second = static_cast<float>(link.second);
                for (std::size_t c = 0; c < n; ++c) {
                    halves[c] += first * sent[c];
                    halves[n + c] += second * sent[c];
                }
            }
            float* to = out.values.data() + k * n;
            for (std::size_t c = 0; c < n; ++c) {
                to[c] = row.per_ray * (halves[c] + halves[n + c]);
                halves[c] = row.per_ray * (halves[c] - halves[n + c]);
            }
            out.variance[k] = static_cast<float>(mean_square(halves.data()));
        }
    });
}

void TestLights::normalize(const Received& rows, const std::vector<double>& weights) {
    std::vector<double> squares(size(), 0.0);
    double all = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        for (std::size_t c = 0; c < size(); ++c) {
            const auto value = static_cast<double>(rows.values[k * size() + c]);
            squares[c] += weights[k] * value * value;
        }
        all += weights[k];
    }
    for (std::size_t k = 0; k < sent_.size(); ++k) {
        const double square = squares[k % size()];
        sent_[k] *= square > 0.0 ? static_cast<float>(std::sqrt(all / square)) : 0.0f;
    }
}

}  // namespace surflux
