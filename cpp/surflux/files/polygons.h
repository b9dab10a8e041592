#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace surflux {

// Polygons of any number of corners: those of polygon i are corners[begin[i]] ... corners[begin[i + 1] - 1].
struct Polygons {
    std::vector<std::size_t> begin{0};
    std::vector<std::uint32_t> corners;
    std::size_t size() const { return begin.size() - 1; }
};

}  // namespace surflux
