#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/transfer/sender_groups.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {

// Means of functions of a basis over surfels, by numbers of their own; of those without (Receivers::none) there are
// none. What has less than a hundredth of a surfel is left to others on its level: two fifths of all entries, which
// change the light by less than a thousandth.
SparseRows means_at_surfels(const SurfelMeans& means, const MultilevelBasis& basis,
                            const std::vector<std::uint32_t>& number, std::size_t surfels, const Progress& progress);

// Over the leaves of senders, from those over surfels: by `areas`, of members of which `outside` is positive, divided
// by `outside` of all. Of functions numbered below `first` or from `last` on.
SparseRows means_at_groups(const SparseRows& at_surfels, const SenderGroups& senders, const std::vector<double>& areas,
                           const std::vector<double>& outside, std::uint32_t first, std::uint32_t last);

}  // namespace surflux
