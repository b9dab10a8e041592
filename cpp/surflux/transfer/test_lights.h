#pragma once

#include <cstddef>
#include <vector>

#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/row_test.h"

namespace surflux {

// Lamps that a transport operator is tried with while it is built, once reflected: random vectors that tell rows apart,
// as for a low-rank approximation (Halko, Martinsson and Tropp 2011).
class TestLights : public RowTest {
public:
    // What senders send of white lamps at some places, when they reflect `reflectance` (by node, three channels).
    TestLights(const CompiledScene& compiled, const TransportOperator& of, const std::vector<float>& reflectance,
               const std::vector<Vec3>& lamps, std::uint64_t seed, const Progress& progress);

    // What rows receive of each lamp.
    void receive(const TransportOperator& of, Received& out) const override;
    // Makes all lamps equally bright: an RMS of 1, where `weights` says how much of the surface rows stand for.
    void normalize(const Received& rows, const std::vector<double>& weights);

private:
    std::vector<float> sent_;  // size() of each node of the senders
};

}  // namespace surflux
