#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/radiosity/pair_exchange.h"
#include "surflux/radiosity/shafts.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// The share of a pair's exchange that nothing blocks, to a stated error.
//   A pair whose shaft is empty is free, without a ray. Of any other, points of both surfels are tried in pairs, each
// weighed by the kernel between them, in eight streams, each even and shifted by its own seed: what they differ by
// gives the standard error. Points are doubled until it is half of what is allowed.
//   Allowed is `error` for what a surfel sends to any set of others: of the factor F of a pair, error
// sqrt(F), F without what blocks it, so that the errors of a row, F summing to at most 1 and the errors being
// independent, make at most `error` together. So a pair's share may be off by error / sqrt(F), and small factors take
// few rays.
//   A pair that is found all free, or all blocked, has been tried so often that a share above that would have been
// met with 95 % probability (3 of its inverse), however it is spread.
class VisibleShare {
public:
    VisibleShare(const Tracer& tracer, const PairExchange& pairs, const Shafts& shafts, double error,
                 std::uint64_t seed, const FormFactorTuning& tuning = {})
        : tracer_(tracer), pairs_(pairs), shafts_(shafts), error_(error), seed_(seed), tuning_(tuning) {}

    struct Share {
        double value = 1.0;
        std::size_t rays = 0;
        bool precise = true;  // false where the most rays that a pair gets did not do
    };
    // `factor`: the larger of F_ij and F_ji, without what blocks it.
    Share operator()(std::uint32_t i, std::uint32_t j, PairExchange::Range range, double factor) const;

private:
    const Tracer& tracer_;
    const PairExchange& pairs_;
    const Shafts& shafts_;
    double error_;
    std::uint64_t seed_;
    FormFactorTuning tuning_;
};

}  // namespace surflux
