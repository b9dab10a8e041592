#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// How the samples of a point are split: in batches of evenly spread paths, and these in chunks traced at once.
struct Batches {
    static constexpr std::size_t least = 16;
    static constexpr std::size_t paths_at_once = 1024;  // one step of all of them fits in the cache

    explicit Batches(std::size_t samples);

    std::size_t per_batch = 1, count, per_chunk, chunks;
};

// Count, mean and sum of squared deviations of batches (Chan, Golub and LeVeque 1983).
struct Moments {
    double count = 0.0;
    Rgb mean, spread;

    void add(const Moments& other);
    Rgb error() const;  // standard, of the mean
};

}  // namespace surflux
