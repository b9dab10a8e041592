#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/team.h"
#include "surflux/transfer/shot_rows.h"

namespace surflux {

// How much memory build_operator takes at its peak for an operator, when more receivers have shot so many rays each. It
// is within a quarter of what was measured on 2568 to 396 410 surfels.
class OperatorMemory {
public:
    // `weights` of functions at surfels, `nodes` of senders.
    OperatorMemory(std::size_t surfels, std::size_t weights, std::size_t test_lights, std::size_t nodes,
                   const ShotRows& so_far, const std::vector<int>& rays);

    double bytes() const;
    // Also with the 32 bits by which rows know their links and entries.
    bool fits(double max_memory) const;
    // Throws ArgumentError unless it fits.
    void require_room(double max_memory) const;
    // How many more receivers with so many rays each.
    std::size_t room_for(double max_memory, int rays) const;

private:
    double surfels_, weights_, test_lights_, nodes_, links_per_ray_, receivers_, links_;
};

// Of processes that run the same program the least that one has, those of one machine an equal share of it: all leave
// out the same.
double available_to_all(const Team& team);

}  // namespace surflux
