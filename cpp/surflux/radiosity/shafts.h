#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surflux/scene/scene.h"

namespace surflux {

// Is anything between two surfels that could block some of the light they exchange? Only a no is certain: it takes the
// shaft between both from their bounding boxes (Haines and Wallace 1991), cut off behind the plane of either, and
// leaves out what has both ends on one side.
class Shafts {
public:
    explicit Shafts(const Scene& scene);

    bool empty(std::uint32_t i, std::uint32_t j) const;

private:
    struct Box {
        Vec3 low, high;
    };
    struct Span {
        double low, high;
    };
    // All that is in the shaft has dot(normal, x) <= limit.
    struct Plane {
        Vec3 normal;
        double limit;
    };
    struct Shaft {
        std::array<Plane, 14> planes;
        std::size_t count = 0;
        Box bounds;
    };

    void find_blockers();
    Shaft between(std::uint32_t i, std::uint32_t j) const;
    static bool is_outside(const Box& box, const Shaft& shaft);
    bool is_outside(std::uint32_t surfel, const Shaft& shaft, std::uint32_t i, std::uint32_t j) const;
    Span span(std::uint32_t surfel, const Vec3& direction) const;
    bool visit(std::size_t node, std::size_t begin, std::size_t end, const Shaft& shaft, std::uint32_t i,
               std::uint32_t j) const;
    void bound(std::size_t node, std::size_t begin, std::size_t end);

    const Surfels& surfels_;
    double touching_;  // what reaches less than this into a shaft does not block it
    std::vector<std::uint32_t> triangles_;
    std::vector<Box> boxes_;  // of the surfels
    // Those that can block anything, along a curve: the walls of a convex room have all else on one side.
    std::vector<std::uint32_t> order_;
    std::vector<Box> nodes_;  // of a binary tree over order_, halved at each level; children of k: 2 k + 1, 2 k + 2
};

}  // namespace surflux
