#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace surflux {

struct LinearReport {
    int applications = 0;   // of the operator, the final check included
    double residual = 0.0;  // largest over systems of |b - A x| / |b|, computed anew at the end
};

// out = A x for interleaved channels.
using LinearOperator = std::function<void(const std::vector<double>& x, std::vector<double>& out)>;

// Which unknowns depend on each other: those of one channel and, where they are given, of one connected part. Each such
// system has a Krylov space and a residual of its own, so that a dim one is solved as well beside a bright one as it
// is alone.
struct LinearSystems {
    LinearSystems(std::size_t channel_count, std::vector<std::uint32_t> part_of = {})
        : channels(channel_count), part(std::move(part_of)) {
        for (const std::uint32_t p : part) parts = std::max<std::size_t>(parts, p + 1);
    }
    std::size_t count() const { return parts * channels; }
    // The system of each of so many unknowns.
    std::vector<std::uint32_t> of(std::size_t unknowns) const {
        std::vector<std::uint32_t> out(unknowns);
        for (std::size_t k = 0; k < unknowns; ++k)
            out[k] = static_cast<std::uint32_t>((part.empty() ? 0 : part[k / channels]) * channels + k % channels);
        return out;
    }
    std::size_t channels, parts = 1;
    std::vector<std::uint32_t> part;  // of each place, whose channels are interleaved; empty: all are one
};

// The inner product of each system, as long as `out`: summed by blocks, so that it is the same for any number of
// threads.
void inner_products(const std::vector<double>& a, const std::vector<double>& b,
                    const std::vector<std::uint32_t>& system, std::vector<double>& out);

// How far an iteration is whose residual falls by about the same factor each time.
std::size_t percent_done(double residual, double tolerance);

}  // namespace surflux
