#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/radiosity/tuning.h"

namespace surflux {

// A cut through the hierarchy: the nodes that light is solved for. Each leaf of the tree is below one of them, or is
// one. Their number in `nodes` is their place, by which unknowns go; their number in the Gathering is their row, which
// stays when the cut changes.
struct Cut {
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> rows;      // of each node
    std::vector<int> rays;                // that each node wants at least
    std::vector<std::uint32_t> place_of;  // of each point, the place of the node above it; none above the cut

    // place_of from `nodes`.
    void find_places(const SurfelTree& tree, const Progress& progress = {});
    // Raises the rays that nodes want to those. Did any want fewer?
    bool want(const std::vector<int>& more);
    // Refines the cut: replaces the chosen nodes by their members, which start from their values, `channels`
    // interleaved, and want rays in proportion to the root of their area. Returns how many were replaced.
    std::size_t replace(const SurfelTree& tree, const std::vector<char>& chosen, std::vector<double>& values,
                        std::size_t channels, const Progress& progress = {});
    // Grading of the cut, as of a balanced quadtree: the inner nodes adjacent to some of less than a 32nd of their
    // area. Interpolation weights follow the density of nodes, so that a coarse one would count for nothing there.
    std::vector<char> unbalanced(const SurfelTree& tree, const RefinementTuning& tuning = {},
                                 const Progress& progress = {}) const;
};

// Where the nodes are: at the points that stand for them.
struct NodePlaces {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;
    NodePlaces(const SurfelTree& tree, const Cut& cut);
};

}  // namespace surflux
