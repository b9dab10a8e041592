#include "surflux/transfer/test_lights.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"

namespace surflux {

namespace {

constexpr std::size_t rays_of_lamp = 16384;
constexpr std::uint64_t sign_stream = 0x7b1d;

// Some of the lamps, each by itself.
class Lamps : public RowTest {
public:
    Lamps(std::size_t count, std::size_t nodes) : RowTest(count, 1.0f), sent(nodes * count, 0.0f) {}

    std::vector<float> sent;  // size() of each node of the senders

private:
    void find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const override {
        for (std::size_t k = begin; k < end; ++k, halves += 2 * size()) add_reflected(of, k, sent, halves);
    }
};

// All of them, each by one process of the team; light_up(l) gives what the leaves send of lamp l.
template <class LightUp>
void light_all(const Team& team, const std::vector<std::uint32_t>& leaves, Lamps& lamps, std::uint64_t digest,
               const LightUp& light_up) {
    const auto make = [&] { for_own_blocks(team, lamps.size(), 1, [&](std::size_t l, std::size_t) { light_up(l); }); };
    if (!team.shares()) return make();
    std::vector<float> column(leaves.size());
    const auto pack = [&](std::size_t l, std::size_t, Packed& to) {
        for (std::size_t k = 0; k < leaves.size(); ++k) column[k] = lamps.sent[leaves[k] * lamps.size() + l];
        to.add(column.data(), column.size());
    };
    const auto unpack = [&](std::size_t l, std::size_t, Unpacking& from) {
        from.take(column.data(), column.size());
        for (std::size_t k = 0; k < leaves.size(); ++k) lamps.sent[leaves[k] * lamps.size() + l] = column[k];
    };
    exchange_blocks(team, "test lights", digest, lamps.size(), 1, make, pack, unpack);
}

}  // namespace

TestLights::TestLights(const GroupLight& light, const SenderGroups& senders, const ShotRows& rows,
                       const std::vector<float>& reflectance, const std::vector<Vec3>& places,
                       const std::vector<double>& weights, std::uint64_t seed, const Progress& progress,
                       const Team& team)
    : RowTest(std::min(sums, places.size()), 1.0f), sent_(senders.size() * size(), 0.0f) {
    const std::vector<std::uint32_t>& leaves = senders.leaves;
    const float share = places.empty() ? 0.0f : 1.0f / std::sqrt(static_cast<float>(places.size()));
    for (std::size_t first = 0; first < places.size(); first += sums) {
        Lamps lamps(std::min(sums, places.size() - first), senders.size());
        const auto light_up = [&](std::size_t l) {
            report(progress, first + l, places.size());
            const std::vector<float> direct = light.irradiance({PointLight{places[first + l], {1.0, 1.0, 1.0}}},
                                                               reflectance, {rays_of_lamp, seed, false, true});
            for (const std::uint32_t leaf : leaves) {
                const float* of_leaf = reflectance.data() + colors * leaf;
                const Rgb reflected{static_cast<double>(of_leaf[0]), static_cast<double>(of_leaf[1]),
                                    static_cast<double>(of_leaf[2])};
                lamps.sent[leaf * lamps.size() + l] = static_cast<float>(luminance(reflected)) * direct[colors * leaf];
            }
        };
        light_all(team, leaves, lamps, digest_of(seed + first, places), light_up);
        senders.pull_up(lamps.sent, lamps.size());
        Received received;
        lamps.receive(rows, received);
        lamps.normalize(received, weights);
        std::vector<float> signs(lamps.size() * size());
        for (std::size_t l = 0; l < lamps.size(); ++l) {
            Random random(seed + sign_stream, first + l);
            for (std::size_t c = 0; c < size(); ++c)
                signs[l * size() + c] = (random.uniform() < 0.5 ? -share : share) * lamps.scale(l);
        }
        parallel_for(leaves.size(), 256, [&](std::size_t k) {
            float* to = sent_.data() + leaves[k] * size();
            const float* from = lamps.sent.data() + leaves[k] * lamps.size();
            for (std::size_t l = 0; l < lamps.size(); ++l) {
                if (from[l] == 0.0f) continue;
                const float* sign = signs.data() + l * size();
                for (std::size_t c = 0; c < size(); ++c) to[c] += sign[c] * from[l];
            }
        });
    }
    senders.pull_up(sent_, size());
}

void TestLights::find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const {
    for (std::size_t k = begin; k < end; ++k, halves += 2 * size()) add_reflected(of, k, sent_, halves);
}

}  // namespace surflux
