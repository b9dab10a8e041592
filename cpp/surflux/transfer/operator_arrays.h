#pragma once

#include <cstddef>

#include "surflux/transfer/transport_operator.h"

namespace surflux {

// visit(name, vector) for each array that a TransportOperator, const or not, is made of: what its file holds. Beside
// them there are four numbers, samples.of_leaf, bounce_levels, rays and left_out.
template <class Operator, class Visit>
void for_arrays(Operator& of, const Visit& visit) {
    visit("positions", of.positions);
    visit("normals", of.normals);
    visit("surfels", of.surfels);
    visit("rows", of.rows);
    visit("links", of.links);
    visit("slopes", of.slopes);
    visit("receiver_of", of.receiver_of);
    visit("level_begin", of.level_begin);
    visit("parents_begin", of.parents.begin);
    visit("parents", of.parents.entries);
    visit("at_groups_begin", of.at_groups.begin);
    visit("at_groups", of.at_groups.entries);
    visit("at_surfels_begin", of.at_surfels.begin);
    visit("at_surfels", of.at_surfels.entries);
    visit("nodes", of.senders.nodes);
    visit("leaf_of_surfel", of.senders.leaf_of_surfel);
    visit("leaves", of.senders.leaves);
    visit("sample_origin", of.samples.origin);
    visit("samples", of.samples.samples);
    visit("areas", of.areas);
}

// Throws ArgumentError, naming the array, unless the operator can be applied to a scene of so many surfels: every index
// has something that it stands for, and all numbers are finite. For operators from files, which anybody may have
// written.
void require_whole(const TransportOperator& of, std::size_t surfels);

}  // namespace surflux
