#pragma once

#include <cstddef>
#include <vector>

#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Lamps that a transport operator is tried with while it is built, once reflected: random vectors that tell rows apart,
// as for a low-rank approximation (Halko, Martinsson and Tropp 2011). What they do not tell apart needs no finer
// receivers, whatever the light.
class TestLights {
public:
    // What senders send of white lamps at some places, when they reflect `reflectance` (by node, three channels).
    TestLights(const CompiledScene& compiled, const TransportOperator& of, const std::vector<float>& reflectance,
               const std::vector<Vec3>& lamps, std::uint64_t seed, const Progress& progress);

    std::size_t size() const { return size_; }

    // By row, what it receives of each lamp, size() interleaved values, and the mean square over lamps of its standard
    // error, from two halves of the rays.
    struct Received {
        std::vector<float> values;
        std::vector<float> variance;
    };
    // Appends the rows of an operator that are not there yet.
    void receive(const TransportOperator& of, Received& out) const;
    // Makes all lamps equally bright: an RMS of 1, where `weights` says how much of the surface rows stand for.
    void normalize(const Received& rows, const std::vector<double>& weights);
    // Mean square over lamps.
    double mean_square(const float* values) const;

private:
    std::size_t size_;
    std::vector<float> sent_;  // size() of each node of the senders
};

}  // namespace surflux
