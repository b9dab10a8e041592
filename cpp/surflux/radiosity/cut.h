#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/surfel_tree.h"

namespace surflux {

// The nodes that light is solved for: each leaf of the tree is below one of them, or is one.
struct Cut {
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> rows;      // of each, in the gathering
    std::vector<std::uint32_t> place_of;  // of each point, its place in `nodes`; none for those above the cut

    // place_of from `nodes`.
    void find_places(const SurfelTree& tree);
    // The chosen nodes give way to their members, which begin with their values, `channels` interleaved. How many did.
    std::size_t replace(const SurfelTree& tree, const std::vector<char>& chosen, std::vector<double>& values,
                        std::size_t channels);
    // Groups, and points that were split, with a node beside them of less than a 32nd of their area: between the two
    // the finer side would have all the say.
    std::vector<char> unbalanced(const SurfelTree& tree, const Progress& progress = {}) const;
};

// Where the nodes are: at the points that stand for them.
struct NodePlaces {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;
    NodePlaces(const SurfelTree& tree, const Cut& cut);
};

}  // namespace surflux
