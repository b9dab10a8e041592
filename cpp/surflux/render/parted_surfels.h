#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Which functions of a field reach a surfel, and speak for no place of it: there is a wall between. Patches end at
// walls, so that this is asked by surfel, of those that pictures see, and not by pixel.
class PartedSurfels {
public:
    PartedSurfels(const MeshlessField& field, const Scene& scene, const BasisSight& sight);

    // To be called before the rest, with surfels in any order.
    void find(std::vector<std::uint32_t> surfels);
    bool is_patch(std::uint32_t i) const { return triangles_[i] != triangles_[i + 1]; }
    bool is_parted(std::uint32_t i) const { return parted_[i].levels != 0; }
    // MeshlessField::at without those functions, and others that hardly reach it; where places differ, by the place.
    // False where none of the coarsest level is left.
    bool at(std::uint32_t i, const Vec3& point, const Vec3& normal, MeshlessField::At& out) const;

private:
    struct Parted {
        std::uint64_t levels = 0;         // a bit for each on which functions are behind walls
        std::vector<std::uint32_t> seen;  // on these, those that speak; ascending
        bool is_mixed = false;            // is any behind walls for some of its places, and for others not?
    };
    Parted parted_from(std::uint32_t i) const;

    const MeshlessField& field_;
    const Scene& scene_;
    const BasisSight& sight_;
    std::vector<std::uint32_t> triangles_;
    std::vector<char> is_known_;
    std::vector<Parted> parted_;
};

}  // namespace surflux
