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
    require(options.radii.empty() || options.radii.size() == positions.size(), "radii: there are ",
            options.radii.size(), ", wanted one for each of ", positions.size(), " positions");
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

double ShepardLevel::weights(const Vec3& point, const Vec3& normal, std::uint32_t object,
                             std::vector<BasisWeight>& out) const {
    out.clear();
    const SupportTree* tree = tree_of(object);
    if (!tree) return 0.0;
    double sum = tree->weights(point, normal, out);
    if (!cuts_.empty()) {
        const std::size_t before = out.size();
        out.erase(std::remove_if(out.begin(), out.end(),
                                 [&](const BasisWeight& w) { return is_beyond_wall(w.function, point); }),
                  out.end());
        if (out.size() < before) {
            sum = 0.0;
            for (const BasisWeight& w : out) sum += w.weight;
        }
    }
    return sum;
}

double ShepardLevel::at(const Vec3& point, const Vec3& normal, std::uint32_t object,
                        std::vector<BasisWeight>& out) const {
    const double sum = weights(point, normal, object, out);
    for (BasisWeight& w : out) w.weight /= sum;
    return sum;
}

void ShepardLevel::set_cuts(std::vector<SupportCut> cuts) {
    std::stable_sort(cuts.begin(), cuts.end(),
                     [](const SupportCut& a, const SupportCut& b) { return a.function < b.function; });
    cuts_ = std::move(cuts);
    first_cut_.assign(size() + 1, 0);
    for (const SupportCut& cut : cuts_) ++first_cut_[cut.function + 1];
    std::partial_sum(first_cut_.begin(), first_cut_.end(), first_cut_.begin());
}

bool ShepardLevel::is_beyond_wall(std::uint32_t function, const Vec3& point) const {
    for (const SupportCut& cut : cuts(function))
        if (dot(cut.normal, point) < cut.offset) return true;
    return false;
}

void ShepardLevel::at_or_nearest(const Vec3& point, const Vec3& normal, std::uint32_t object,
                                 std::vector<BasisWeight>& out) const {
    at(point, normal, object, out);
    if (!out.empty()) return;
    if (const SupportTree* tree = tree_of(object)) out.assign(1, {tree->nearest(point, normal), 1.0});
}

}  // namespace surflux
