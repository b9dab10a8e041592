#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Light as linear solvers take it, channels interleaved: one where the scene is grey, so that nothing is computed three
// times to be the same.
struct Channels {
    explicit Channels(bool grey) : count(grey ? 1 : 3) {}
    template <class Values>
    std::vector<double> pack(const Values& values) const {
        std::vector<double> out(values.size() * count);
        for (std::size_t i = 0; i < values.size(); ++i)
            for (std::size_t c = 0; c < count; ++c) out[i * count + c] = values[i][static_cast<int>(c)];
        return out;
    }
    Rgb unpack(const std::vector<double>& values, std::size_t i) const {
        if (count == 1) return {values[i], values[i], values[i]};
        return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    }
    std::vector<Rgb> unpack(const std::vector<double>& values) const {
        std::vector<Rgb> out(values.size() / count);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = unpack(values, i);
        return out;
    }
    std::size_t count;
};

}  // namespace surflux
