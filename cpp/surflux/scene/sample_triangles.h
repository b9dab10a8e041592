#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

struct SurfacePoint {
    Vec3 position;
    std::uint32_t triangle;
};

// `count` points on triangles, uniform over their area; one in each of `count` slices of equal area.
class TriangleSamples {
public:
    TriangleSamples(std::vector<std::array<Vec3, 3>> triangles, std::size_t count, std::uint64_t seed);

    std::size_t size() const { return count_; }
    SurfacePoint operator[](std::size_t i) const;
    double area() const { return up_to_.back(); }  // of the triangles

private:
    std::vector<std::array<Vec3, 3>> triangles_;
    std::vector<double> up_to_;  // area up to each triangle, and with it
    std::size_t count_;
    std::uint64_t seed_;
};

}  // namespace surflux
