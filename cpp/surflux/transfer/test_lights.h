#pragma once

#include <cstddef>
#include <vector>

#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/row_test.h"

namespace surflux {

// Lamps that a transport operator is tried with while it is built, once reflected: random vectors that tell rows apart,
// as for a low-rank approximation (Halko, Martinsson and Tropp 2011). Of rows it is what they receive of each lamp.
class TestLights : public RowTest {
public:
    // What senders send of white lamps at some places, when they reflect `reflectance` (by node, three channels).
    TestLights(const CompiledScene& compiled, const TransportOperator& of, const std::vector<float>& reflectance,
               const std::vector<Vec3>& lamps, std::uint64_t seed, const Progress& progress);

private:
    void find(const TransportOperator& of, std::size_t begin, std::size_t end, float* halves) const override;

    std::vector<float> sent_;  // size() of each node of the senders
};

}  // namespace surflux
