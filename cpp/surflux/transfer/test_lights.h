#pragma once

#include <cstddef>
#include <vector>

#include "surflux/transfer/group_light.h"
#include "surflux/transfer/row_test.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

// Lamps that a transport operator is tried with while it is built, once reflected: random vectors that tell rows apart,
// as for a low-rank approximation (Halko, Martinsson and Tropp 2011). What rows receive of them is kept in a few
// random sums with signs, whose mean square is that over all lamps (Johnson and Lindenstrauss 1984).
class TestLights : public RowTest {
public:
    // White lamps at some places, reflected by `reflectance` (by node, `colors` each); each counts alike, with an RMS
    // of 1 over the first rows, that stand for `weights` of the surface. Processes of a team light some of them each.
    TestLights(const GroupLight& light, const SenderGroups& senders, const ShotRows& rows,
               const std::vector<float>& reflectance, const std::vector<Vec3>& lamps,
               const std::vector<double>& weights, std::uint64_t seed, const Progress& progress, const Team& team = {});

    static constexpr std::size_t sums = 64;

protected:
    // In the shade of a contact less light is not less of an error. Of once what is there, receivers were half as many
    // again, and no better.
    double local_weight() const override { return 2.0; }

private:
    void find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const override;

    std::vector<float> sent_;  // size() of each node of the senders
};

}  // namespace surflux
