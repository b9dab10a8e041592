#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/meshless/dart_throwing.h"

namespace surflux {

// The conflict graph of a window of proposals: pairs closer than their Poisson disks allow, and the order in which they
// came, by which the first of a pair wins (parallel dart throwing).
struct ConflictGraph {
    // `grid` is one that suits the radius.
    ConflictGraph(const std::vector<Proposal>& proposals, const Fill& fill, const PointGrid& grid);

    // Those that came before it and stand in its way.
    Span<std::uint32_t> earlier(std::uint32_t k) const {
        const std::uint32_t* list = lists_[k / block].data();
        return {list + begin_[k], list + end_[k]};
    }

    std::vector<std::uint32_t> order;

private:
    static constexpr std::size_t block = 512;

    std::vector<std::vector<std::uint32_t>> lists_;  // of each block of proposals
    std::vector<std::uint32_t> begin_, end_;
};

}  // namespace surflux
