#include "surflux/radiosity/surfel_tree.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/scene/patch_cells.h"

namespace surflux {

SurfelTree::SurfelTree(const Scene& scene, const Hierarchy& hierarchy, std::size_t most_leaves,
                       const Progress& progress, const RefinementTuning& tuning)
    : scene_(scene), surfels_(scene.surfels.size()), leaves_(surfels_), most_leaves_(std::max(most_leaves, surfels_)) {
    // A split adds four points and three leaves.
    const std::size_t room = surfels_ + (most_leaves_ - surfels_) / (children - 1) * children;
    triangles_ = triangle_ranges(scene.surfels);
    first_group_ = static_cast<std::uint32_t>(room);
    child_.assign(surfels_, none);
    group_of_surfel_.assign(surfels_, none);
    std::uint32_t below = 0, here = first_group_;
    levels_.push_back(0);
    for (const Hierarchy::Level& level : hierarchy.levels) {
        for (std::uint32_t g = 0; g < level.size(); ++g) {
            report_some(progress, g, surfels_, 1 << 18);
            const auto first = static_cast<std::uint32_t>(members_.size());
            for (std::uint32_t m = level.first[g]; m < level.first[g + 1]; ++m) {
                const std::uint32_t member = level.members[m];
                members_.push_back(below + member);
                if (below == 0)
                    group_of_surfel_[member] = here + g;
                else
                    group_of_group_[below + member - first_group_] = here + g;
            }
            groups_.push_back({first, static_cast<std::uint32_t>(members_.size()), level.representatives[g],
                               level.areas[g], level.radii[g]});
            group_of_group_.push_back(none);
        }
        below = here;
        here += static_cast<std::uint32_t>(level.size());
        levels_.push_back(here - first_group_);
    }
    if (!hierarchy.levels.empty()) nearest_.emplace(scene, progress, tuning);
}

std::int32_t SurfelTree::level(std::uint32_t node) const {
    if (!is_point(node)) {
        const auto above = std::upper_bound(levels_.begin(), levels_.end(), node - first_group_);
        return static_cast<std::int32_t>(above - levels_.begin());
    }
    // Each has half the radius of what it was inserted below.
    return -static_cast<std::int32_t>(std::lround(std::log2(scene_.surfels.radii[surfel(node)] / radius(node))));
}

std::pair<std::uint32_t, std::uint32_t> SurfelTree::level_of_at_least(std::size_t count) const {
    for (std::size_t l = levels_.size() - 1; l-- > 0;)
        if (levels_[l + 1] - levels_[l] >= count) return {first_group_ + levels_[l], first_group_ + levels_[l + 1]};
    return {0, static_cast<std::uint32_t>(surfels_)};
}

std::uint32_t SurfelTree::sender(std::uint32_t surfel, const Vec3& at, double reach) const {
    if (nearest_) surfel = nearest_->owner(surfel, at);
    std::uint32_t group = group_of_surfel_[surfel];
    if (group == none || groups_[group - first_group_].radius > reach) {
        std::uint32_t node = surfel;
        while (first_child(node) != none && radius(node) > reach) {
            std::uint32_t nearest = first_child(node);
            for (std::uint32_t k = 1; k < children; ++k)
                if (length_squared(position(first_child(node) + k) - at) < length_squared(position(nearest) - at))
                    nearest = first_child(node) + k;
            node = nearest;
        }
        return node;
    }
    for (;;) {
        const std::uint32_t above = group_of_group_[group - first_group_];
        if (above == none || groups_[above - first_group_].radius > reach) return group;
        group = above;
    }
}

std::uint32_t SurfelTree::split(std::uint32_t leaf, const Child (&below)[children]) {
    const auto first = static_cast<std::uint32_t>(points());
    const double quarter = area(leaf) / children, half = 0.5 * radius(leaf);
    const std::uint32_t from = surfel(leaf);
    for (const Child& child : below) {
        inserted_.positions.push_back(child.position);
        inserted_.normals.push_back(child.normal);
        inserted_.reflectance.push_back(child.reflectance);
        inserted_.radii.push_back(half);
        inserted_.areas.push_back(quarter);
        origin_.push_back(from);
        cells_.emplace_back();
        inserted_child_.push_back(none);
    }
    (leaf < surfels_ ? child_[leaf] : inserted_child_[leaf - surfels_]) = first;
    leaves_ += children - 1;
    return first;
}

Span<Triangle> SurfelTree::piece(std::uint32_t p) const {
    if (p >= surfels_) return cells_[p - surfels_];
    const Triangle* all = scene_.surfels.triangles.data();
    return {all + triangles_[p], all + triangles_[p + 1]};
}

void SurfelTree::share_patch(std::uint32_t parent) {
    Vec3 at[children];
    for (std::uint32_t k = 0; k < children; ++k) at[k] = position(first_child(parent) + k);
    const Span<Triangle> whole = piece(parent);
    std::vector<std::vector<Triangle>> cells = patch_cells(whole.begin(), whole.end(), at, children);
    double sum = 0.0, areas[children] = {};
    for (std::uint32_t k = 0; k < children; ++k) {
        for (const Triangle& t : cells[k]) areas[k] += area_of(t);
        sum += areas[k];
    }
    for (std::uint32_t k = 0; k < children; ++k) {
        const std::size_t child = first_child(parent) + k - surfels_;
        if (sum > 0.0) inserted_.areas[child] = area(parent) * (areas[k] / sum);
        cells_[child] = std::move(cells[k]);
    }
}

std::vector<std::uint32_t> SurfelTree::all_leaves() const {
    std::vector<std::uint32_t> out;
    out.reserve(leaves_);
    for (std::uint32_t i = 0; i < surfels_; ++i) visit_leaves(i, [&](std::uint32_t p) { out.push_back(p); });
    return out;
}

Surfels SurfelTree::surfels_at(const std::vector<std::uint32_t>& leaves, const Progress& progress) const {
    std::vector<std::uint32_t> from(leaves.size());
    for (std::size_t k = 0; k < leaves.size(); ++k) from[k] = surfel(leaves[k]);
    Surfels out = select(scene_.surfels, from, progress);
    std::vector<std::uint32_t>().swap(from);
    for (std::size_t k = 0; k < leaves.size(); ++k) {
        const std::uint32_t p = leaves[k];
        if (!is_inserted(p)) continue;
        out.positions[k] = position(p);
        out.normals[k] = normal(p);
        out.radii[k] = radius(p);
        out.areas[k] = area(p);
    }
    report(progress, leaves.size(), leaves.size());
    out.reflectance = {};
    out.reflectance.reserve(leaves.size());
    for (const std::uint32_t p : leaves) out.reflectance.push_back(reflectance(p));
    report(progress, leaves.size(), leaves.size());
    const auto drop = [&](const auto& part) { return is_inserted(leaves[part.surfel]); };
    out.triangles.clear();
    for (std::uint32_t k = 0; k < leaves.size(); ++k)
        for (Triangle t : piece(leaves[k])) {
            t.surfel = k;
            out.triangles.push_back(t);
        }
    out.ends.erase(std::remove_if(out.ends.begin(), out.ends.end(), drop), out.ends.end());
    return out;
}

void SurfelTree::pull_up(std::vector<double>& values, std::size_t channels) const {
    values.resize(size() * channels);
    const auto average = [&](std::uint32_t node) {
        double* sum = values.data() + node * channels;
        for (std::size_t c = 0; c < channels; ++c) sum[c] = 0.0;
        for_members(node, [&](std::uint32_t m) {
            for (std::size_t c = 0; c < channels; ++c) sum[c] += area(m) * values[m * channels + c];
        });
        for (std::size_t c = 0; c < channels; ++c) sum[c] /= area(node);
    };
    // Children stand behind their parents.
    if (points() > surfels_)
        for (std::size_t p = points(); p-- > 0;)
            if (const auto node = static_cast<std::uint32_t>(p); first_child(node) != none) average(node);
    for (std::size_t l = 0; l + 1 < levels_.size(); ++l)
        parallel_for(levels_[l + 1] - levels_[l], 512,
                     [&](std::size_t k) { average(first_group_ + levels_[l] + static_cast<std::uint32_t>(k)); });
}

void SurfelTree::push_down(std::vector<double>& values) const {
    const auto share_out = [&](std::size_t k) {
        const auto node = static_cast<std::uint32_t>(k);
        if (values[node] == 0.0) return;
        const double density = values[node] / area(node);
        for_members(node, [&](std::uint32_t member) { values[member] += density * area(member); });
    };
    for (std::size_t l = levels_.size(); l-- > 1;)
        parallel_for(levels_[l] - levels_[l - 1], 512,
                     [&](std::size_t k) { share_out(first_group_ + levels_[l - 1] + k); });
    // Children stand behind their parents.
    if (points() > surfels_)
        for (std::size_t p = 0; p < points(); ++p) share_out(p);
}

}  // namespace surflux
