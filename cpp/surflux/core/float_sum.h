#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace surflux {

// Sums of so many floats that lie one after another, weighted: sum.add(weight, from), then sum.write(to).
class FloatSum {
public:
    explicit FloatSum(std::size_t count) : sums_(count, 0.0f) {}
    void add(float weight, const float* from) {
        for (float& sum : sums_) sum += weight * *from++;
    }
    void write(float* to) const { std::copy(sums_.begin(), sums_.end(), to); }
    const float* data() const { return sums_.data(); }

private:
    std::vector<float> sums_;
};

// The same of a known number, a multiple of 4: in SIMD registers, of which one has four floats on all processors.
// (Compilers vectorize such loops the other way, over what is added, and gather every number by itself.)
template <std::size_t count>
class Float4Sum {
public:
    void add(float weight, const float* from) {
        for (std::size_t k = 0; k < count / 4; ++k) {
            Four values;
            std::memcpy(&values, from + 4 * k, sizeof values);
            sums_[k] += weight * values;
        }
    }
    void write(float* to) const { std::memcpy(to, sums_, sizeof sums_); }
    const float* data() const { return reinterpret_cast<const float*>(sums_); }

private:
    static_assert(count % 4 == 0);
    typedef float Four __attribute__((vector_size(16)));
    Four sums_[count / 4] = {};
};

// Of a number that is an std::integral_constant, or is not.
template <std::size_t count>
Float4Sum<count> float_sum(std::integral_constant<std::size_t, count>) {
    return {};
}
inline FloatSum float_sum(std::size_t count) { return FloatSum(count); }

}  // namespace surflux
