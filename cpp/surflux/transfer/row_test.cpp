#include "surflux/transfer/row_test.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double significance = 2.0;  // standard errors that a difference must be beyond

}  // namespace

void RowTest::receive(const ShotRows& of, Received& out, const Team& team) const {
    const std::size_t from = out.variance.size(), n = size();
    out.values.resize(of.rows.size() * n, 0.0f);
    out.variance.resize(of.rows.size(), 0.0f);
    const auto body = [&](std::size_t begin, std::size_t end) {
        std::vector<float> halves(2 * n * (end - begin));
        find(of, from + begin, from + end, halves.data());
        for (std::size_t k = begin; k < end; ++k) {
            float* first = halves.data() + 2 * n * (k - begin);
            const float* second = first + n;
            float* values = out.values.data() + n * (from + k);
            for (std::size_t c = 0; c < n; ++c) {
                values[c] = 0.5f * scale_[c] * (first[c] + second[c]);
                first[c] = 0.5f * scale_[c] * (first[c] - second[c]);
            }
            out.variance[from + k] = static_cast<float>(mean_square(first));
        }
    };
    const auto pack = [&](std::size_t begin, std::size_t end, Packed& to) {
        to.add(out.values.data() + n * (from + begin), n * (end - begin));
        to.add(out.variance.data() + from + begin, end - begin);
    };
    const auto unpack = [&](std::size_t begin, std::size_t end, Unpacking& of_others) {
        of_others.take(out.values.data() + n * (from + begin), n * (end - begin));
        of_others.take(out.variance.data() + from + begin, end - begin);
    };
    const auto digest = [&] { return digest_of(from, of.positions); };
    shared_blocks(team, "differences", digest, of.rows.size() - from, 16, body, pack, unpack, {});
}

void RowTest::add_reflected(const ShotRows& of, std::size_t k, const std::vector<float>& sent, float* halves) const {
    const ShotRows::Row& row = of.rows[k];
    const std::size_t n = size();
    for (std::uint32_t l = row.begin; l < row.end; ++l) {
        const ShotRows::Link& link = of.links[l];
        const float* from = sent.data() + link.sender * n;
        const float first = 2.0f * row.per_ray * static_cast<float>(link.first);
        const float second = 2.0f * row.per_ray * static_cast<float>(link.second);
        for (std::size_t c = 0; c < n; ++c) {
            halves[c] += first * from[c];
            halves[n + c] += second * from[c];
        }
    }
}

void RowTest::normalize(const Received& rows, const std::vector<double>& weights) {
    const std::size_t n = size();
    std::vector<double> squares(n, 0.0);
    double all = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        for (std::size_t c = 0; c < n; ++c) {
            const auto value = static_cast<double>(rows.values[k * n + c]);
            squares[c] += weights[k] * value * value;
        }
        all += weights[k];
    }
    for (std::size_t c = 0; c < n; ++c)
        scale_[c] *= squares[c] > 0.0 ? static_cast<float>(std::sqrt(all / squares[c])) : 0.0f;
}

void RowTest::normalize_together(Received& rows, const std::vector<double>& weights, double wanted, bool only_up) {
    double sum = 0.0, all = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        sum += weights[k] * mean_square(rows.values.data() + k * size());
        all += weights[k];
    }
    const double factor = sum > 0.0 ? wanted * std::sqrt(all / sum) : 0.0;
    if (only_up && factor < 1.0) return;
    for (float& scale : scale_) scale *= static_cast<float>(factor);
    for (float& value : rows.values) value *= static_cast<float>(factor);
    for (float& variance : rows.variance) variance *= static_cast<float>(factor * factor);
}

double RowTest::mean_square(const float* values) const {
    double sum = 0.0;
    for (std::size_t c = 0; c < size(); ++c) sum += static_cast<double>(values[c] * values[c]);
    return size() > 0 ? sum / static_cast<double>(size()) : 0.0;
}

bool RowTest::is_off(const float* values, const float* difference, double allowed, float variance) const {
    double off = 0.0, own = 0.0, other = 0.0;
    for (std::size_t c = 0; c < size(); ++c) {
        const auto value = static_cast<double>(values[c]), by = static_cast<double>(difference[c]);
        off += by * by, own += value * value, other += (value - by) * (value - by);
    }
    const auto n = static_cast<double>(size());
    const double most = allowed * std::min(1.0, local_weight() * std::sqrt(std::max(own, other) / n));
    return off / n > most * most + significance * significance * static_cast<double>(variance);
}

}  // namespace surflux
