#include "surflux/transfer/reflections.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double negligible = 1e-3;  // of all the light that is sent: what another bounce would bring
constexpr int most_bounces = 1000;

// By area, of what is below 0, too: harmonics of a light may be.
double power(const SenderGroups& senders, const std::vector<float>& sent, std::size_t channels) {
    return parallel_sum<double>(senders.leaves.size(), 2048, [&](std::size_t k, double& sum) {
        const std::uint32_t leaf = senders.leaves[k];
        for (std::size_t c = 0; c < channels; ++c)
            sum += static_cast<double>(senders.nodes[leaf].area) *
                   std::abs(static_cast<double>(sent[channels * leaf + c]));
    });
}

}  // namespace

std::vector<float> sent_after(int bounces, const TransportOperator& transport, std::size_t channels,
                              const std::vector<float>& emission, const std::vector<float>& reflectance,
                              const std::vector<float>& direct) {
    const SenderGroups& senders = transport.senders;
    std::vector<float> sent = emission, all = emission, received(sent.size(), 0.0f), values, coefs;
    double bright = power(senders, sent, channels);
    for (int bounce = 1; bounce <= (bounces < 0 ? most_bounces : bounces); ++bounce) {
        if (bright > 0.0) {
            senders.pull_up(sent, channels);
            transport.gather(sent, channels, values, TransportOperator::Part::bounces);
            transport.coefficients(values, channels, coefs, TransportOperator::Part::bounces);
            transport.receive(coefs, channels, received);
        }
        parallel_for(senders.leaves.size(), 2048, [&](std::size_t of_leaf) {
            const std::size_t leaf = senders.leaves[of_leaf];
            for (std::size_t c = 0; c < channels; ++c) {
                const std::size_t k = channels * leaf + c;
                if (bounce == 1) received[k] += direct[k];
                sent[k] = reflectance[colors * leaf + c % colors] * received[k];
                all[k] += sent[k];
            }
        });
        bright = power(senders, sent, channels);
        if (bright == 0.0) break;
        if (bounces < 0 && bright <= negligible * power(senders, all, channels)) break;
    }
    senders.pull_up(all, channels);
    return all;
}

}  // namespace surflux
