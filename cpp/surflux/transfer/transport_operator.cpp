#include "surflux/transfer/transport_operator.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/transfer/tilted_light.h"

namespace surflux {

Place TransportOperator::place(std::size_t row) const {
    return {positions[row], normals[row], surfels[row], row < first_own_row() ? Place::point : surfels[row]};
}

void TransportOperator::gather(const std::vector<float>& sent, std::size_t channels, std::vector<float>& out,
                               Part part) const {
    constexpr std::size_t ahead = 32;
    out.resize(rows.size() * channels);
    const std::size_t end_of_basis = first_own_row(), own = rows.size() - end_of_basis;
    const std::size_t first =
        part == Part::all ? end_of_basis : std::min<std::size_t>(end_of_basis, level_begin[bounce_end()]);
    if (channels == colors)
        return parallel_blocks(first + own, 128, [&](std::size_t begin, std::size_t end) {
            const std::size_t middle = std::clamp(first, begin, end);
            gather_color_rows(*this, sent.data(), begin, middle, out.data());
            gather_color_rows(*this, sent.data(), middle - first + end_of_basis, end - first + end_of_basis,
                              out.data());
        });
    with_fixed(channels, [&](const auto count) {
        parallel_for(first + own, 128, [&](std::size_t in_part) {
            const std::size_t k = in_part < first ? in_part : in_part - first + end_of_basis;
            const Row& row = rows[k];
            auto sum = float_sum(count);
            for (std::uint32_t l = row.begin; l < row.end; ++l) {
                if (l + ahead < links.size()) __builtin_prefetch(sent.data() + sender(links[l + ahead]) * count);
                sum.add(rays_of(links[l]), sent.data() + sender(links[l]) * count);
            }
            float* to = out.data() + k * count;
            sum.write(to);
            for (std::size_t c = 0; c < count; ++c) to[c] *= row.per_ray;
        });
    });
}

void TransportOperator::gather_tilted(const std::vector<float>& sent, std::vector<float>& out) const {
    out.resize(rows.size() * tilted_channels);
    parallel_blocks(rows.size(), 128, [&](std::size_t begin, std::size_t end) {
        gather_tilted_rows(*this, sent.data(), begin, end, out.data());
    });
}

void TransportOperator::coefficients(const std::vector<float>& values, std::size_t channels, std::vector<float>& out,
                                     Part part) const {
    out.resize(receiver_of.size() * channels);
    const std::size_t last = own_level();
    with_fixed(channels, [&](const auto count) {
        for (std::size_t level = 0; level <= last; ++level) {
            if (part == Part::bounces && level >= bounce_end() && level != last) continue;
            parallel_for(level_begin[level + 1] - level_begin[level], 256, [&](std::size_t k) {
                const std::size_t j = level_begin[level] + k;
                auto sum = float_sum(count);
                for (std::uint32_t p = parents.begin[j]; p < parents.begin[j + 1]; ++p)
                    sum.add(-parents.entries[p].weight, out.data() + parents.entries[p].column * count);
                sum.add(1.0f, values.data() + receiver_of[j] * count);
                sum.write(out.data() + j * count);
            });
        }
    });
}

void TransportOperator::receive(const std::vector<float>& coefs, std::size_t channels, std::vector<float>& out) const {
    out.resize(senders.size() * channels);
    with_fixed(channels, [&](const auto count) {
        at_groups.multiply(coefs, count, [&](std::size_t leaf, const float* sums) {
            std::copy_n(sums, std::size_t{count}, out.data() + senders.leaves[leaf] * count);
        });
    });
}

std::vector<float> TransportOperator::losses() const {
    std::vector<float> values, coefs, out(2 * at_surfels.rows());
    for (const Row& row : rows)
        for (const std::uint16_t share : {row.escape, row.into_backs})
            values.push_back(static_cast<float>(share) / ShotRows::share_scale);
    coefficients(values, 2, coefs);
    at_surfels.multiply(coefs, 2, [&](std::size_t i, const float* shares) {
        for (std::size_t c = 0; c < 2; ++c) out[2 * i + c] = std::clamp(shares[c], 0.0f, 1.0f);
    });
    return out;
}

std::size_t TransportOperator::bytes() const {
    const auto of = [](const auto& v) { return v.size() * sizeof v[0]; };
    return of(positions) + of(normals) + of(surfels) + of(rows) + of(links) + of(slopes) + of(receiver_of) +
           of(level_begin) + of(parents.begin) + of(parents.entries) + of(at_groups.begin) + of(at_groups.entries) +
           of(at_surfels.begin) + of(at_surfels.entries) + of(senders.nodes) + of(senders.leaf_of_surfel) +
           of(senders.leaves) + of(samples.origin) + of(samples.samples) + of(areas);
}

}  // namespace surflux
