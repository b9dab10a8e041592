#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/meshless/dart_throwing.h"

namespace surflux {

// For parallel dart throwing: which darts (proposals) of a batch are closer to each other than their Poisson disks
// allow, and the order of their random priorities. A dart is accepted if none of those in earlier() was: darts may be
// proposed in parallel, and the outcome is that of throwing them one by one in that order.
struct ConflictGraph {
    // `grid`: whose cells suit the radius of `fill`.
    ConflictGraph(const std::vector<Proposal>& proposals, const Fill& fill, const PointGrid& grid);

    // Darts in conflict with dart k that come before it.
    Span<std::uint32_t> earlier(std::uint32_t k) const {
        const std::uint32_t* list = lists_[k / block].data();
        return {list + begin_[k], list + end_[k]};
    }

    std::vector<std::uint32_t> order;  // of all darts, by priority

private:
    static constexpr std::size_t block = 512;

    std::vector<std::vector<std::uint32_t>> lists_;  // of each block of proposals
    std::vector<std::uint32_t> begin_, end_;
};

}  // namespace surflux
