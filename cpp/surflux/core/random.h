#pragma once

#include <cstdint>

namespace surflux {

// Random numbers that depend on (seed, stream) alone, so that work split over any number of threads draws the same.
// splitmix64 (Steele, Lea and Flood 2014).
class Random {
public:
    explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix(mix(seed) + stream)) {}

    std::uint64_t bits() { return mix(state_ += 0x9e3779b97f4a7c15ull); }
    // Uniform in [0, 1): the upper 53 bits, as many as a double has.
    double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    // Uniform in {0, ..., n - 1}: the upper half of a product of 128 bits, biased by less than n / 2^64.
    std::uint64_t below(std::uint64_t n) {
        return static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits()) * n) >> 64);
    }

private:
    static std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
    std::uint64_t state_;
};

}  // namespace surflux
