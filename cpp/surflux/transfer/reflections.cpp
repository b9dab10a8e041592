#include "surflux/transfer/reflections.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double negligible = 1e-3;  // of all the light that is sent: what another bounce would bring
constexpr int most_bounces = 1000;

struct Power {
    double sent = 0.0, all = 0.0;
    Power& operator+=(const Power& other) {
        sent += other.sent, all += other.all;
        return *this;
    }
};

// By area, of what is below 0, too: harmonics of a light may be.
double power_of(const SenderGroups& senders, std::uint32_t leaf, const std::vector<float>& sent, std::size_t channels) {
    double sum = 0.0;
    for (std::size_t c = 0; c < channels; ++c) sum += std::abs(static_cast<double>(sent[channels * leaf + c]));
    return static_cast<double>(senders.nodes[leaf].area) * sum;
}

}  // namespace

std::vector<float> sent_after(int bounces, const TransportOperator& transport, std::size_t channels,
                              const std::vector<float>& emission, const std::vector<float>& reflectance,
                              const std::vector<float>& direct) {
    const SenderGroups& senders = transport.senders;
    std::vector<float> sent = emission, all = emission, received(sent.size(), 0.0f), values, coefs;
    double bright = parallel_sum<double>(senders.leaves.size(), 2048, [&](std::size_t k, double& sum) {
        sum += power_of(senders, senders.leaves[k], sent, channels);
    });
    for (int bounce = 1; bounce <= (bounces < 0 ? most_bounces : bounces); ++bounce) {
        if (bright > 0.0) {
            senders.pull_up(sent, channels);
            transport.gather(sent, channels, values, TransportOperator::Part::bounces);
            transport.coefficients(values, channels, coefs, TransportOperator::Part::bounces);
            transport.receive(coefs, channels, received);
        }
        const auto found = parallel_sum<Power>(senders.leaves.size(), 2048, [&](std::size_t of_leaf, Power& sum) {
            const std::uint32_t leaf = senders.leaves[of_leaf];
            for (std::size_t c = 0; c < channels; ++c) {
                const std::size_t k = channels * leaf + c;
                if (bounce == 1) received[k] += direct[k];
                sent[k] = reflectance[colors * leaf + c % colors] * received[k];
                all[k] += sent[k];
            }
            sum.sent += power_of(senders, leaf, sent, channels);
            if (bounces < 0) sum.all += power_of(senders, leaf, all, channels);
        });
        bright = found.sent;
        if (bright == 0.0) break;
        if (bounces < 0 && bright <= negligible * found.all) break;
    }
    senders.pull_up(all, channels);
    return all;
}

}  // namespace surflux
