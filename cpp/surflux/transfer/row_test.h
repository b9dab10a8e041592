#pragma once

#include <cstddef>
#include <vector>

#include "surflux/transfer/transport_operator.h"

namespace surflux {

// What tells the rows of a transport operator apart while it is built: some numbers of each. What they do not tell
// apart needs no finer receivers, whatever the light.
class RowTest {
public:
    explicit RowTest(std::size_t size) : size_(size) {}
    virtual ~RowTest() = default;

    // By row, size() interleaved values, and the mean square of their standard error, from two halves of the rays.
    struct Received {
        std::vector<float> values;
        std::vector<float> variance;
    };
    // Appends the rows of an operator that are not there yet.
    virtual void receive(const TransportOperator& of, Received& out) const = 0;

    std::size_t size() const { return size_; }
    double mean_square(const float* values) const {
        double sum = 0.0;
        for (std::size_t c = 0; c < size_; ++c) sum += static_cast<double>(values[c] * values[c]);
        return size_ > 0 ? sum / static_cast<double>(size_) : 0.0;
    }

private:
    std::size_t size_;
};

}  // namespace surflux
