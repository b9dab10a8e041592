#include "surflux/lights/lit_patches.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "surflux/scene/extent.h"

namespace surflux {

namespace {

constexpr std::uint32_t none = 0xffffffffu;
// On Sponza, 4096 gave as much variance.
constexpr std::size_t most_groups = 512;
// Opposite normals are as far apart as points by this share of the diagonal.
constexpr double normals_apart = 0.1;

}  // namespace

struct LitPatches::Group {
    std::size_t begin, end;
    double power = 0.0;
    double mean[6] = {}, variance[6] = {};  // of positions, and of normals in their unit
    // What splitting it may gain.
    double spread() const { return power * std::accumulate(variance, variance + 6, 0.0); }
    bool operator<(const Group& other) const { return spread() < other.spread(); }
};

LitPatches::LitPatches(const Surfels& surfels, const SurfelPoints& points, const std::vector<double>& exitance)
    : points_(points) {
    std::vector<double> power(surfels.size());
    double of_disks = 0.0, of_patches = 0.0;
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
        if (!(exitance[i] > 0.0)) continue;
        if (!points.is_patch(i)) {
            of_disks += surfels.areas[i] * exitance[i];
            continue;
        }
        patches_.push_back(i);
        of_patches += power[i] = points.area(i) * exitance[i];  // of that on which points are drawn
    }
    if (patches_.empty()) return;
    share_ = of_patches / (of_patches + of_disks);
    group_.assign(surfels.size(), none);
    exitance_.resize(surfels.size());
    for (const std::uint32_t i : patches_) {
        power[i] /= of_patches;
        exitance_[i] = exitance[i] / of_patches;
    }
    const Extent extent(surfels);
    origin_ = extent.middle;
    unit_ = extent.size;
    for (const Group& g : split(surfels, power)) add(surfels, power, g);
    begin_.push_back(static_cast<std::uint32_t>(patches_.size()));
}

// Puts patches_ in the order of groups, which are split where that may gain most.
std::vector<LitPatches::Group> LitPatches::split(const Surfels& surfels, const std::vector<double>& power) {
    const double normal_unit = 0.5 * normals_apart;
    const auto coordinate = [&](std::uint32_t i, int axis) {
        return axis < 3 ? (surfels.positions[i][axis] - origin_[axis]) / unit_
                        : normal_unit * surfels.normals[i][axis - 3];
    };
    const auto group = [&](std::size_t begin, std::size_t end) {
        Group g{begin, end};
        for (std::size_t k = begin; k < end; ++k) g.power += power[patches_[k]];
        for (int axis = 0; axis < 6; ++axis) {
            for (std::size_t k = begin; k < end; ++k)
                g.mean[axis] += power[patches_[k]] / g.power * coordinate(patches_[k], axis);
            for (std::size_t k = begin; k < end; ++k) {
                const double off = coordinate(patches_[k], axis) - g.mean[axis];
                g.variance[axis] += power[patches_[k]] / g.power * off * off;
            }
        }
        return g;
    };
    std::priority_queue<Group> open;
    open.push(group(0, patches_.size()));
    std::vector<Group> done;
    while (!open.empty() && open.size() + done.size() < most_groups) {
        const Group g = open.top();
        open.pop();
        const auto axis = static_cast<int>(std::max_element(g.variance, g.variance + 6) - g.variance);
        const auto first = patches_.begin();
        const auto middle = std::stable_partition(first + static_cast<std::ptrdiff_t>(g.begin),
                                                  first + static_cast<std::ptrdiff_t>(g.end),
                                                  [&](std::uint32_t i) { return coordinate(i, axis) < g.mean[axis]; });
        const auto split = static_cast<std::size_t>(middle - first);
        if (split == g.begin || split == g.end) {  // they are all alike
            done.push_back(g);
            continue;
        }
        open.push(group(g.begin, split));
        open.push(group(split, g.end));
    }
    for (; !open.empty(); open.pop()) done.push_back(open.top());
    std::sort(done.begin(), done.end(), [](const Group& a, const Group& b) { return a.begin < b.begin; });
    for (Group& g : done) {
        for (int axis = 3; axis < 6; ++axis) g.mean[axis] /= normal_unit, g.variance[axis] /= normal_unit * normal_unit;
    }
    return done;
}

void LitPatches::add(const Surfels& surfels, const std::vector<double>& power, const Group& g) {
    double sum = 0.0, widest = 0.0;
    for (std::size_t k = g.begin; k < g.end; ++k) {
        const std::uint32_t i = patches_[k];
        up_to_.push_back(sum += power[i]);
        group_[i] = static_cast<std::uint32_t>(begin_.size());
        widest = std::max(widest, surfels.areas[i]);
    }
    begin_.push_back(static_cast<std::uint32_t>(g.begin));
    power_.push_back(static_cast<float>(sum));
    x_.push_back(static_cast<float>(g.mean[0]));
    y_.push_back(static_cast<float>(g.mean[1]));
    z_.push_back(static_cast<float>(g.mean[2]));
    normal_x_.push_back(static_cast<float>(g.mean[3]));
    normal_y_.push_back(static_cast<float>(g.mean[4]));
    normal_z_.push_back(static_cast<float>(g.mean[5]));
    const double* v = g.variance;
    radius_.push_back(static_cast<float>(std::sqrt(v[0] + v[1] + v[2] + widest / (3.0 * unit_ * unit_))));
    normal_spread_.push_back(static_cast<float>(std::sqrt(v[3] + v[4] + v[5])));
}

// As from its centre, but with cosines as large as they may be for its size and normals, and no nearer than its size.
bool LitPatches::aim(const Vec3& point, const Vec3& normal, Aim& out) const {
    out.resize(power_.size());
    const Vec3 at = (point - origin_) / unit_;
    const auto px = static_cast<float>(at.x), py = static_cast<float>(at.y), pz = static_cast<float>(at.z);
    const auto nx = static_cast<float>(normal.x), ny = static_cast<float>(normal.y), nz = static_cast<float>(normal.z);
    for (std::size_t g = 0; g < power_.size(); ++g) {
        const float dx = x_[g] - px, dy = y_[g] - py, dz = z_[g] - pz, size = radius_[g];
        const float squared = dx * dx + dy * dy + dz * dz + 1e-30f, inverse = 1.0f / std::sqrt(squared);
        const float wide = std::min(1.0f, size * inverse);
        const float here = (dx * nx + dy * ny + dz * nz) * inverse + wide;
        const float there =
            wide + normal_spread_[g] - (dx * normal_x_[g] + dy * normal_y_[g] + dz * normal_z_[g]) * inverse;
        out[g] =
            power_[g] * std::clamp(here, 0.0f, 1.0f) * std::clamp(there, 0.0f, 1.0f) / std::max(squared, size * size);
    }
    std::partial_sum(out.begin(), out.end(), out.begin());
    return !out.empty() && out.back() > 0.0f;
}

LitPatches::Target LitPatches::sample(const Aim& aim, double choice, double u, double v) const {
    const auto wanted = static_cast<float>(choice * static_cast<double>(aim.back()));
    // The first that reaches beyond it, and so one that brings something.
    auto g = static_cast<std::size_t>(std::upper_bound(aim.begin(), aim.end(), wanted) - aim.begin());
    if (g == aim.size())
        g = static_cast<std::size_t>(std::lower_bound(aim.begin(), aim.end(), aim.back()) - aim.begin());
    const float before = g > 0 ? aim[g - 1] : 0.0f;
    const double rest = std::clamp(static_cast<double>((wanted - before) / (aim[g] - before)), 0.0, 1.0);
    const auto from = up_to_.begin() + begin_[g], to = up_to_.begin() + begin_[g + 1];
    const auto found = std::min(std::upper_bound(from, to, rest * *(to - 1)), to - 1);
    const std::uint32_t i = patches_[static_cast<std::size_t>(found - up_to_.begin())];
    return {points_.at(i, u, v), i};
}

double LitPatches::density(const Aim& aim, std::uint32_t surfel) const {
    const std::uint32_t g = group_[surfel];
    if (g == none) return 0.0;
    const float share = aim[g] - (g > 0 ? aim[g - 1] : 0.0f);
    return static_cast<double>(share / aim.back()) * exitance_[surfel] / up_to_[begin_[g + 1] - 1];
}

}  // namespace surflux
