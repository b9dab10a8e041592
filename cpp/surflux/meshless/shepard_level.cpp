#include "surflux/meshless/shepard_level.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/error.h"

namespace surflux {

namespace {

void check(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
           const std::vector<std::uint32_t>& objects, const SupportOptions& options) {
    require(normals.size() == positions.size(), "normals: there are ", normals.size(), ", wanted one for each of ",
            positions.size(), " positions");
    require(objects.size() == positions.size(), "objects: there are ", objects.size(), ", wanted one for each of ",
            positions.size(), " positions");
    require(options.neighbors >= 1, "neighbors: got ", options.neighbors, ", wanted at least 1");
    require(options.largest_radius > 0.0, "largest_radius: got ", options.largest_radius, ", wanted more than 0");
    for (std::size_t j = 0; j < positions.size(); ++j) {
        require(is_finite(positions[j]), "positions: number ", j, " is not finite");
        require(std::abs(length(normals[j]) - 1.0) < 1e-3, "normals: number ", j, " is not of unit length");
    }
}

}  // namespace

ShepardLevel::ShepardLevel(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                           const std::vector<std::uint32_t>& objects, const SupportOptions& options) {
    check(positions, normals, objects, options);
    radii_ = support_radii(positions, normals, objects, options);
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return objects[a] < objects[b]; });
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        while (end < order.size() && objects[order[end]] == objects[order[begin]]) ++end;
        objects_.push_back(objects[order[begin]]);
        trees_.emplace_back(positions, normals, radii_, Span<std::uint32_t>(order.data() + begin, order.data() + end));
    }
}

const SupportTree* ShepardLevel::tree_of(std::uint32_t object) const {
    const auto at = std::lower_bound(objects_.begin(), objects_.end(), object);
    return at == objects_.end() || *at != object ? nullptr : &trees_[static_cast<std::size_t>(at - objects_.begin())];
}

void ShepardLevel::at(const Vec3& point, const Vec3& normal, std::uint32_t object,
                      std::vector<BasisWeight>& out) const {
    const SupportTree* tree = tree_of(object);
    if (!tree) return out.clear();
    const double scale = 1.0 / tree->weights(point, normal, out);
    for (BasisWeight& w : out) w.weight *= scale;
}

void ShepardLevel::at_or_nearest(const Vec3& point, const Vec3& normal, std::uint32_t object,
                                 std::vector<BasisWeight>& out) const {
    at(point, normal, object, out);
    if (!out.empty()) return;
    if (const SupportTree* tree = tree_of(object)) out.assign(1, {tree->nearest(point, normal), 1.0});
}

}  // namespace surflux
