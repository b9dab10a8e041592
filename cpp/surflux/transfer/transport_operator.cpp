#include "surflux/transfer/transport_operator.h"

#include <algorithm>

#include "surflux/core/parallel.h"

namespace surflux {

void TransportOperator::gather(const std::vector<float>& sent, std::size_t channels, std::vector<float>& out) const {
    out.assign(rows.size() * channels, 0.0f);
    with_fixed(channels, [&](const auto count) {
        parallel_for(rows.size(), 128, [&](std::size_t k) {
            const Row& row = rows[k];
            float* sum = out.data() + k * count;
            for (std::uint32_t l = row.begin; l < row.end; ++l) {
                const Link& link = links[l];
                const float share = row.per_ray * static_cast<float>(link.first + link.second);
                const float* from = sent.data() + link.sender * count;
                for (std::size_t c = 0; c < count; ++c) sum[c] += share * from[c];
            }
        });
    });
}

void TransportOperator::gather_tilted(const std::vector<float>& sent, std::vector<float>& out) const {
    constexpr std::size_t n = 3 * tilted_channels;
    out.resize(rows.size() * n);
    parallel_for(rows.size(), 128, [&](std::size_t k) {
        const Row& row = rows[k];
        float value[3] = {}, u[3] = {}, v[3] = {};
        for (std::uint32_t l = row.begin; l < row.end; ++l) {
            const Link& link = links[l];
            const float share = row.per_ray * static_cast<float>(link.first + link.second);
            const float along_u = share / slope_scale * static_cast<float>(link.u);
            const float along_v = share / slope_scale * static_cast<float>(link.v);
            const float* from = sent.data() + 3 * link.sender;
            for (int c = 0; c < 3; ++c) {
                value[c] += share * from[c];
                u[c] += along_u * from[c];
                v[c] += along_v * from[c];
            }
        }
        const Frame frame = frame_around(normals[k]);
        float* to = out.data() + k * n;
        for (int c = 0; c < 3; ++c) {
            const float tilt_u = u[c] - row.u * value[c], tilt_v = v[c] - row.v * value[c];
            to[c] = value[c];
            for (int axis = 0; axis < 3; ++axis)
                to[3 * (axis + 1) + c] =
                    tilt_u * static_cast<float>(frame.u[axis]) + tilt_v * static_cast<float>(frame.v[axis]);
        }
    });
}

void TransportOperator::coefficients(const std::vector<float>& values, std::size_t channels,
                                     std::vector<float>& out) const {
    out.resize(receiver_of.size() * channels);
    with_fixed(channels, [&](const auto count) {
        for (std::size_t level = 0; level + 1 < level_begin.size(); ++level)
            parallel_for(level_begin[level + 1] - level_begin[level], 256, [&](std::size_t k) {
                const std::size_t j = level_begin[level] + k;
                float* to = out.data() + j * count;
                const float* from = values.data() + receiver_of[j] * count;
                for (std::size_t c = 0; c < count; ++c) to[c] = from[c];
                for (std::uint32_t p = parents.begin[j]; p < parents.begin[j + 1]; ++p) {
                    const float weight = parents.entries[p].weight;
                    const float* parent = out.data() + parents.entries[p].column * count;
                    for (std::size_t c = 0; c < count; ++c) to[c] -= weight * parent[c];
                }
            });
    });
}

void TransportOperator::receive(const std::vector<float>& coefs, std::size_t channels, std::vector<float>& out) const {
    out.assign(senders.size() * channels, 0.0f);
    at_groups.multiply(coefs, channels, [&](std::size_t leaf, const float* sums) {
        std::copy_n(sums, channels, out.data() + senders.leaves[leaf] * channels);
    });
}

std::size_t TransportOperator::bytes() const {
    const auto of = [](const auto& v) { return v.size() * sizeof v[0]; };
    return of(positions) + of(normals) + of(surfels) + of(rows) + of(links) + of(receiver_of) + of(level_begin) +
           of(parents.begin) + of(parents.entries) + of(at_groups.begin) + of(at_groups.entries) +
           of(at_surfels.begin) + of(at_surfels.entries) + of(senders.nodes) + of(senders.leaf_of_surfel) +
           of(senders.leaves) + of(samples.positions) + of(samples.surfels) + of(areas);
}

}  // namespace surflux
