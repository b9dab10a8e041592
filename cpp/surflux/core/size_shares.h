#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace surflux {

// How much each of many sizes is of all that are not larger, by powers of two. Other than a share of all it does not
// depend on what is larger: a room's walls have the same, be there ground for miles around or not. Shares of n sizes
// add up to 1 where they are alike, and to some logarithm of their ratios where not.
class SizeShares {
public:
    void add(double size) {
        if (size > 0.0) sums_[bin(size)] += size;
    }
    // For parallel_sum.
    SizeShares& operator+=(const SizeShares& other) {
        for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += other.sums_[k];
        return *this;
    }
    double share(double size) const {
        if (!(size > 0.0)) return 0.0;
        double below = 0.0;
        for (std::size_t k = 0; k <= bin(size); ++k) below += sums_[k];
        return below > 0.0 ? std::min(1.0, size / below) : 1.0;
    }

private:
    static constexpr int smallest = -128;
    static std::size_t bin(double size) {
        return static_cast<std::size_t>(std::clamp(std::ilogb(size) - smallest, 0, 2 * -smallest - 1));
    }
    std::array<double, 2 * -smallest> sums_ = {};
};

}  // namespace surflux
