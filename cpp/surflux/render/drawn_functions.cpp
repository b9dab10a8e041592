#include "surflux/render/drawn_functions.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

bool is_zero(const Rgb& c) { return c == Rgb{}; }

// Those of [begin, end) whose support may meet that of one at whose point light was gathered.
std::vector<char> near_gathered(const MeshlessField& field, std::uint32_t begin, std::uint32_t end) {
    const MultilevelBasis& basis = field.basis;
    std::vector<char> needed(end - begin, 0);
    std::vector<Vec3> places;
    std::vector<std::uint32_t> functions;
    double largest = 0.0;
    for (std::uint32_t j = begin; j < end; ++j) {
        if (!field.gathered[j]) continue;
        needed[j - begin] = 1;
        places.push_back(basis.position(j));
        functions.push_back(j);
        largest = std::max(largest, basis.radius(j));
    }
    if (functions.empty() || functions.size() == needed.size()) return needed;
    const PointIndex index(places);
    parallel_blocks(needed.size(), 512, [&](std::size_t first, std::size_t last) {
        std::vector<Neighbor> found;
        for (std::size_t k = first; k < last; ++k) {
            if (needed[k]) continue;
            const std::uint32_t j = begin + static_cast<std::uint32_t>(k);
            found.clear();
            index.within(basis.position(j), basis.radius(j) + largest, found);
            needed[k] = std::any_of(found.begin(), found.end(), [&](const Neighbor& other) {
                const std::uint32_t i = functions[other.index];
                return basis.object(i) == basis.object(j) && other.distance < basis.radius(i) + basis.radius(j);
            });
        }
    });
    return needed;
}

}  // namespace

DrawnFunctions::DrawnFunctions(const MeshlessField& field) {
    const MultilevelBasis& basis = field.basis;
    for (std::size_t level = 0; level < basis.levels(); ++level) {
        const std::uint32_t begin = basis.first(level), end = basis.first(level + 1);
        for (std::uint32_t j = begin; j < end; ++j) {
            if (basis.object(j) >= coarsest.size()) coarsest.resize(basis.object(j) + std::size_t{1}, -1);
            if (coarsest[basis.object(j)] < 0) coarsest[basis.object(j)] = static_cast<std::int32_t>(level);
        }
        const std::vector<char> near = near_gathered(field, begin, end);
        std::vector<std::uint32_t>& drawn = levels.emplace_back();
        for (std::uint32_t j = begin; j < end; ++j) {
            const bool covers = coarsest[basis.object(j)] == static_cast<std::int32_t>(level);
            if (basis.radius(j) > 0.0 && (covers || near[j - begin])) drawn.push_back(j);
        }
    }
    for (const MeshlessField::At& value : field.values) largest = std::max(largest, largest_channel(value.all));
    direct = !std::all_of(field.direct.begin(), field.direct.end(), is_zero);
}

}  // namespace surflux
