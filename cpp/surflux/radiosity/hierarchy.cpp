#include "surflux/radiosity/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/sheet_index.h"

namespace surflux {

namespace {

constexpr std::size_t groups_per_report = 4096;

// What a level groups: surfels, or the groups of the level below.
struct Members {
    const std::vector<Vec3>& positions;
    const std::vector<Vec3>& normals;
    const std::vector<double>& radii;
    const std::vector<double>& areas;
    std::size_t size() const { return positions.size(); }
};

// All numbers below n, in random order.
std::vector<std::uint32_t> shuffled(std::size_t n, Random random, const Progress& progress) {
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = n; i > 1; --i) {
        std::swap(order[i - 1], order[random.below(i)]);
        report_some(progress, i, n, 1 << 20);
    }
    return order;
}

// D04 eq. 10: a member chosen at random takes all that no group has yet and that lie within b = 2 R of it, with normals
// less than epsilon off its own; and so on until none is left.
Hierarchy::Level grow_groups(const Members& members, const std::vector<std::uint32_t>& object, double epsilon,
                             Random random, const JoinedSurfels& joined, const Progress& progress) {
    const std::size_t n = members.size();
    std::vector<double> reach(n);
    for (std::size_t i = 0; i < n; ++i) reach[i] = 2.0 * members.radii[i];
    const Progress preparing = standing_at(0, n, progress);
    SheetIndex index(members.positions, members.normals, reach, object, epsilon, preparing);
    // Objects side by side: they share no groups.
    struct Growing {
        std::vector<std::uint32_t> order;  // in which members are chosen
        std::size_t next = 0;
        std::vector<std::uint32_t> taken, first;  // in the order in which groups grow
    };
    std::vector<Growing> growing(*std::max_element(object.begin(), object.end()) + std::size_t{1});
    for (const std::uint32_t i : shuffled(n, random, preparing)) growing[object[i]].order.push_back(i);
    for (std::size_t done = 0; done < n;) {
        parallel_for(growing.size(), 1, [&](std::size_t k) {
            Growing& of = growing[k];
            for (std::size_t groups = 0; groups < groups_per_report && of.next < of.order.size(); ++of.next) {
                const std::uint32_t i = of.order[of.next];
                if (index.is_taken(i)) continue;
                of.first.push_back(static_cast<std::uint32_t>(of.taken.size()));
                index.take(i, of.taken, joined);
                std::sort(of.taken.begin() + of.first.back() + 1, of.taken.end());
                ++groups;
            }
        });
        done = 0;
        for (const Growing& of : growing) done += of.next < of.order.size() ? of.taken.size() : of.order.size();
        report(progress, done, n);
    }
    std::vector<std::uint32_t> taken, first;
    taken.reserve(n);
    for (Growing& of : growing) {
        for (const std::uint32_t begin : of.first) first.push_back(begin + static_cast<std::uint32_t>(taken.size()));
        taken.insert(taken.end(), of.taken.begin(), of.taken.end());
        of = {};
    }
    first.push_back(static_cast<std::uint32_t>(n));

    // Numbered along the index, not at random: groups that are close in space are so in memory.
    std::vector<std::uint32_t> order(first.size() - 1);
    std::iota(order.begin(), order.end(), 0u);
    const auto rank = [&](std::uint32_t g) { return index.rank(taken[first[g]]); };
    parallel_sort(order, [&](std::uint32_t a, std::uint32_t b) { return rank(a) < rank(b); }, preparing);
    Hierarchy::Level level;
    level.parent_of.resize(n);
    level.members.reserve(n);
    level.first.push_back(0);
    for (std::uint32_t g : order) {
        for (std::uint32_t k = first[g]; k < first[g + 1]; ++k) {
            level.parent_of[taken[k]] = static_cast<std::uint32_t>(level.first.size() - 1);
            level.members.push_back(taken[k]);
        }
        level.first.push_back(static_cast<std::uint32_t>(level.members.size()));
    }
    return level;
}

// Averages by area; where there is no area, plain ones.
void average(const Members& members, Hierarchy::Level& level, const Progress& progress) {
    const std::size_t groups = level.first.size() - 1;
    level.positions.resize(groups);
    level.normals.resize(groups);
    level.areas.resize(groups);
    const auto average_one = [&](std::size_t g) {
        const auto begin = level.members.begin() + level.first[g], end = level.members.begin() + level.first[g + 1];
        double area = 0.0;
        for (auto m = begin; m != end; ++m) area += members.areas[*m];
        const Vec3 origin = members.positions[*begin];  // survey coordinates must not cost digits
        Vec3 offset, normal;
        for (auto m = begin; m != end; ++m) {
            const double weight = area > 0.0 ? members.areas[*m] / area : 1.0 / static_cast<double>(end - begin);
            offset += weight * (members.positions[*m] - origin);
            normal += weight * members.normals[*m];
        }
        level.positions[g] = origin + offset;
        // Below epsilon = 0 normals may cancel: then the group faces as the one it was grown from.
        level.normals[g] = length(normal) > 1e-6 ? normalized(normal) : members.normals[*begin];
        level.areas[g] = area;
    };
    parallel_for(groups, 1024, average_one, progress);
}

// How far the farthest point of a disk is.
double distance_to_far_rim(const Vec3& from, const Vec3& center, const Vec3& normal, double radius) {
    const Vec3 d = center - from;
    const double above = dot(d, normal);
    const double along = std::sqrt(std::max(0.0, length_squared(d) - above * above));
    return std::hypot(along + radius, above);
}

// The spheres enclose the disks of the surfels, not the spheres below, which would make them larger with every level.
void enclose(const Surfels& surfels, const std::vector<std::uint32_t>& group_of, Hierarchy::Level& level,
             const Progress& progress) {
    const std::size_t n = surfels.size();
    std::vector<double> value(n);
    const auto find_distance = [&](std::size_t i) {
        const Vec3& center = level.positions[group_of[i]];
        value[i] = distance_to_far_rim(center, surfels.positions[i], surfels.normals[i], surfels.radii[i]);
    };
    parallel_for(n, 4096, find_distance, progress);
    level.radii.assign(level.size(), 0.0);
    for (std::size_t i = 0; i < n; ++i) level.radii[group_of[i]] = std::max(level.radii[group_of[i]], value[i]);

    const auto find_difference = [&](std::size_t i) {
        const std::uint32_t g = group_of[i];
        const double off = length(surfels.positions[i] - level.positions[g]) / level.radii[g];
        value[i] = off * off + length_squared(surfels.normals[i] - level.normals[g]);
    };
    parallel_for(n, 4096, find_difference, progress);
    constexpr std::uint32_t none = 0xffffffffu;
    level.representatives.assign(level.size(), none);
    for (std::uint32_t i = 0; i < n; ++i) {
        std::uint32_t& best = level.representatives[group_of[i]];
        if (best == none || value[i] < value[best]) best = i;
    }
}

void check(const Surfels& surfels, const std::vector<std::uint32_t>& object, const HierarchyOptions& options) {
    const std::size_t n = surfels.size();
    require(n >= 1, "surfels: there are none to group");
    require(surfels.areas.size() == n, "areas: wanted one for each of ", n, " surfels, got ", surfels.areas.size());
    for (std::size_t i = 0; i < n; ++i)
        require(surfels.radii[i] > 0.0, "radii: wanted above 0, got ", surfels.radii[i], " at index ", i);
    require(object.size() == n, "object: wanted a number for each of ", n, " surfels, got ", object.size());
    require(std::abs(options.epsilon) < 1.0, "epsilon: wanted a number in (-1, 1), got ", options.epsilon);
    require(options.max_levels >= 0, "max_levels: wanted at least 0, got ", options.max_levels);
}

}  // namespace

std::vector<std::uint32_t> Hierarchy::groups(std::size_t level) const {
    require(level < levels.size(), "level: wanted below ", levels.size(), ", got ", level);
    std::vector<std::uint32_t> out = levels[0].parent_of;
    for (std::size_t k = 1; k <= level; ++k)
        for (std::uint32_t& g : out) g = levels[k].parent_of[g];
    return out;
}

Hierarchy build_hierarchy(const Surfels& surfels, const std::vector<std::uint32_t>& object,
                          const HierarchyOptions& options, const Progress& progress, const JoinedSurfels& joined) {
    check(surfels, object, options);
    Hierarchy out;
    std::vector<std::uint32_t> group_of(surfels.size());  // of each surfel, on the level below
    std::iota(group_of.begin(), group_of.end(), 0u);
    std::vector<std::uint32_t> object_of = object;  // of each member
    while (options.max_levels == 0 || out.levels.size() < static_cast<std::size_t>(options.max_levels)) {
        const bool lowest = out.levels.empty();
        const Hierarchy::Level* below = lowest ? nullptr : &out.levels.back();
        const Members members = lowest ? Members{surfels.positions, surfels.normals, surfels.radii, surfels.areas}
                                       : Members{below->positions, below->normals, below->radii, below->areas};
        // The first level is most of the work: of the others only whether to go on is asked.
        const Progress asking = standing_at(surfels.size(), surfels.size(), progress);
        const Random random(options.seed, out.levels.size());
        JoinedSurfels joined_members;
        if (joined)
            joined_members = [&](std::uint32_t a, std::uint32_t b) {
                return lowest ? joined(a, b) : joined(below->representatives[a], below->representatives[b]);
            };
        Hierarchy::Level level =
            grow_groups(members, object_of, options.epsilon, random, joined_members, lowest ? progress : asking);
        const auto groups = static_cast<double>(level.first.size() - 1);
        if (!lowest && groups > (1.0 - options.least_shrinking) * static_cast<double>(members.size())) break;
        average(members, level, asking);
        for (std::uint32_t& g : group_of) g = level.parent_of[g];
        enclose(surfels, group_of, level, asking);
        std::vector<std::uint32_t> objects(level.size());
        for (std::size_t g = 0; g < level.size(); ++g) objects[g] = object_of[level.members[level.first[g]]];
        object_of = std::move(objects);
        out.levels.push_back(std::move(level));
        report(progress, surfels.size(), surfels.size());
        if (groups == 1.0) break;
    }
    return out;
}

Hierarchy build_hierarchy(const Scene& scene, const Sight& sight, const HierarchyOptions& options,
                          const Progress& progress) {
    const std::vector<Sight::Place> places = sight.places(progress);
    return build_hierarchy(scene.surfels, scene.object, options, progress,
                           [&](std::uint32_t i, std::uint32_t j) { return sight.joined(places[i], places[j]); });
}

}  // namespace surflux
