#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/radiosity/hierarchy.h"
#include "surflux/radiosity/nearest_disks.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"

namespace surflux {

// The hierarchy that light is gathered in: the surfels of a scene, the children inserted below them (D04 7.2), and the
// groups above. Every node sends the mean of its members by area; leaves are what has none: surfels that were not
// split, and inserted ones. Nodes go by one number: surfels as in the scene, inserted ones behind them, groups behind
// all that there is room for.
class SurfelTree {
public:
    static constexpr std::uint32_t none = 0xffffffffu;
    static constexpr std::uint32_t children = 4;

    // `most_leaves`: the room for insertion.
    SurfelTree(const Scene& scene, const Hierarchy& hierarchy, std::size_t most_leaves, const Progress& progress = {},
               const RefinementTuning& tuning = {});

    std::size_t size() const { return first_group_ + groups_.size(); }  // of arrays by node; some stay unused
    std::size_t points() const { return surfels_ + inserted_.size(); }  // surfels and inserted ones
    std::size_t leaves() const { return leaves_; }
    std::size_t room() const { return most_leaves_ - leaves_; }
    bool has_room() const { return room() >= children - 1; }  // for a split

    bool is_point(std::uint32_t node) const { return node < first_group_; }
    bool is_leaf(std::uint32_t node) const { return is_point(node) && first_child(node) == none; }
    bool is_inserted(std::uint32_t node) const { return node >= surfels_ && is_point(node); }
    // Of a point.
    const Vec3& position(std::uint32_t p) const { return of(scene_.surfels.positions, inserted_.positions, p); }
    const Vec3& normal(std::uint32_t p) const { return of(scene_.surfels.normals, inserted_.normals, p); }
    double radius(std::uint32_t p) const { return of(scene_.surfels.radii, inserted_.radii, p); }
    const Rgb& reflectance(std::uint32_t p) const { return of(scene_.surfels.reflectance, inserted_.reflectance, p); }
    const Rgb& emission(std::uint32_t p) const { return scene_.surfels.emission[surfel(p)]; }
    // The surfel of the scene that a point is, or was inserted below.
    std::uint32_t surfel(std::uint32_t p) const { return p < surfels_ ? p : origin_[p - surfels_]; }
    std::uint32_t object(std::uint32_t p) const { return scene_.object[surfel(p)]; }
    std::uint32_t first_child(std::uint32_t p) const { return of(child_, inserted_child_, p); }
    // Of any node.
    double area(std::uint32_t node) const {
        return is_point(node) ? of(scene_.surfels.areas, inserted_.areas, node) : groups_[node - first_group_].area;
    }
    // A point.
    std::uint32_t representative(std::uint32_t node) const {
        return is_point(node) ? node : groups_[node - first_group_].representative;
    }
    template <class Visit>
    void for_members(std::uint32_t node, const Visit& visit) const {
        if (is_point(node)) {
            for (std::uint32_t k = 0; k < children && first_child(node) != none; ++k) visit(first_child(node) + k);
            return;
        }
        const Group& group = groups_[node - first_group_];
        for (std::uint32_t m = group.first; m < group.last; ++m) visit(members_[m]);
    }
    // Levels that groups stand above the surfels: from 1 up; 0 of a surfel, -1 and so on of inserted ones.
    std::int32_t level(std::uint32_t node) const;
    // A level of groups, the coarsest that has at least so many; else the surfels.
    std::pair<std::uint32_t, std::uint32_t> level_of_at_least(std::size_t count) const;

    // What sends when a surfel is met at a place: the leaf there, or the largest group around it that a circle of
    // radius `reach` covers.
    std::uint32_t sender(std::uint32_t surfel, const Vec3& at, double reach) const;
    // Nothing more is met: what sender() alone needs is given back.
    void end_of_rays() { nearest_.reset(); }

    struct Child {
        Vec3 position, normal;
        Rgb reflectance;
    };
    // Replaces a leaf by four of half its radius and a quarter of its area. Returns the first.
    std::uint32_t split(std::uint32_t leaf, const Child (&below)[children]);
    void move(std::uint32_t inserted, const Vec3& position) { inserted_.positions[inserted - surfels_] = position; }
    void turn(std::uint32_t inserted, const Vec3& normal) { inserted_.normals[inserted - surfels_] = normal; }
    // Gives the children of a patch the parts of it that are nearest to each, and their areas.
    void share_patch(std::uint32_t parent);
    // The triangles of a patch, or of the part of one that an inserted point stands for; none of a disk.
    Span<Triangle> piece(std::uint32_t p) const;

    // Those of one surfel after those of the one before.
    std::vector<std::uint32_t> all_leaves() const;
    // Points as surfels: with their triangles, or the part of those that is theirs.
    Surfels surfels_at(const std::vector<std::uint32_t>& leaves, const Progress& progress = {}) const;

    // Fills in what all nodes send from what leaves do: `channels` interleaved values each.
    void pull_up(std::vector<double>& values, std::size_t channels) const;
    // The transpose of that: shares out what nodes have among their members, by area.
    void push_down(std::vector<double>& values) const;
    // Calls visit(node) for all nodes, each before its members.
    template <class Visit>
    void for_downwards(const Visit& visit) const {
        for (std::size_t l = levels_.size(); l-- > 1;)
            for (std::uint32_t k = levels_[l - 1]; k < levels_[l]; ++k) visit(first_group_ + k);
        for (std::uint32_t p = 0; p < points(); ++p) visit(p);
    }

private:
    struct Group {
        std::uint32_t first, last;  // in members_
        std::uint32_t representative;
        double area, radius;
    };
    template <class Visit>
    void visit_leaves(std::uint32_t p, const Visit& visit) const {
        if (first_child(p) == none) return visit(p);
        for (std::uint32_t k = 0; k < children; ++k) visit_leaves(first_child(p) + k, visit);
    }
    template <class Values>
    auto of(const Values& given, const Values& added, std::uint32_t p) const -> decltype(given[p]) {
        return p < surfels_ ? given[p] : added[p - surfels_];
    }

    const Scene& scene_;
    std::size_t surfels_, leaves_, most_leaves_;
    std::uint32_t first_group_;
    Surfels inserted_;
    std::vector<std::uint32_t> origin_;                  // of inserted ones
    std::vector<std::vector<Triangle>> cells_;           // of inserted ones, where they lie on a patch
    std::vector<std::uint32_t> triangles_;               // where those of each surfel begin
    std::vector<std::uint32_t> child_, inserted_child_;  // of surfels and inserted ones: the first of four, or none
    std::vector<std::uint32_t> group_of_surfel_;         // or none
    std::optional<NearestDisks> nearest_;
    std::vector<std::uint32_t> group_of_group_;
    std::vector<Group> groups_;
    std::vector<std::uint32_t> members_;
    std::vector<std::uint32_t> levels_;  // first group of each, and the end
};

}  // namespace surflux
