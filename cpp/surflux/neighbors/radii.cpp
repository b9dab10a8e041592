#include "surflux/neighbors/radii.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/tangent_cell.h"

namespace surflux {

namespace {

// Neighbours: the first look completes most cells, the second all but those on borders.
constexpr std::size_t first_look = 20, second_look = 60;
// In the lines of a scanner all of these can lie in a point's own line, and a disk that reaches half way to the lines
// beside it needs four times as many neighbours as these are apart in steps along them: up to 100 steps.
constexpr std::size_t last_look = 480;
constexpr double slender = 0.1;         // width over length of neighbours that lie in a line
constexpr double in_plane = 0.2;        // of its distance a point of another line may stand off
constexpr double beside = 0.5;          // of its distance it lies to one side, at least
constexpr double between_lines = 0.75;  // of the distance between them: as far away disks of two lines meet, at most
// As far away as so many times the twelfth neighbour, a corner of the cell lies beyond a border. Of clouds of random
// points 4e-4 of the light gets through at 1.9 and without a border.
constexpr double beyond = 1.9;
constexpr std::size_t twelfth = 12;
constexpr std::size_t ring = 6;
// On the border of a small piece the twelfth is far away, or on another surface: how dense the piece is, where there is
// any of it, say those about as high as the point, as many as there are, and the share of directions that they are in.
constexpr double as_high = 0.5;         // of its distance one of them stands off the tangent plane, at most
constexpr double usual_gap = 0.5 * pi;  // between the directions of twelve all around: the widest, on average
constexpr double least_share = 0.5;     // the root of the least share of directions
// Of the distance from which on corners are beyond a border: as far aside what is lower or higher than that shows that
// the surface has ended.
constexpr double surely_beyond = 2.0 / 3.0;
constexpr double same_face = 0.8;  // cosine between normals, as for areas (D04 eq. 10)
// Over the third smallest of the six radii around: at most, so that disks do not bridge a hole with the others on its
// rim, and at most in order to cover a sheet of one's own. At rims and tips the neighbours that face the other way are
// the same surface, and disks that looked past them would stick out.
constexpr std::size_t modest = 2;
constexpr double outlier_ratio = 2.5, own_sheet_ratio = 1.5;
// Tangent disks that just cover meet in edges, or miss each other where the surface twists: of the rays from inside of
// closed clouds (statues, noisy spheres, a cube) up to 9e-4 get out at 1, 4e-4 at 1.05, 2e-4 at 1.1, 4e-5 at 1.2.
// Larger disks in turn shade what they stand off.
constexpr double margin = 1.1;

// The plane that the points around lie in; where they lie on a line, one through it.
Vec3 plane_around(const std::vector<Vec3>& places, const std::vector<Neighbor>& near, const Vec3& point) {
    const Vec3 normal = plane_normal(places, near);
    if (length_squared(normal) > 0.0) return normal;
    return frame_around(normalized(places[near.back().index] - point)).u;
}

// The normal of each place; zero where points that face opposite ways share one, or without normals.
std::vector<Vec3> normals_of_places(const DistinctPlaces& distinct, const std::vector<Vec3>& normals) {
    std::vector<Vec3> out(distinct.places.size());
    if (normals.empty()) return out;
    std::vector<bool> seen(out.size(), false);
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const std::uint32_t place = distinct.of_point[i];
        if (!seen[place]) out[place] = normals[i];
        if (dot(out[place], normals[i]) < 0.0) out[place] = {};
        seen[place] = true;
    }
    return out;
}

// How far a disk has to reach to cover its part of its own sheet, and of whatever is around.
struct Reach {
    double own, all;
};

class RadiusEstimate {
public:
    RadiusEstimate(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const Progress& progress)
        : points_(points),
          normals_(normals),
          distinct_(distinct_places(points, standing_at(0, points.size(), progress))),
          facing_(normals_of_places(distinct_, normals)),
          index_(checked(distinct_.places), standing_at(0, points.size(), progress)) {}

    std::size_t around() const { return std::min(ring, distinct_.places.size() - 1); }
    std::size_t places() const { return distinct_.places.size(); }
    std::uint32_t place(std::size_t i) const { return distinct_.of_point[i]; }

    // Scratch memory of a thread.
    struct Work {
        std::vector<Neighbor> near;
        TangentCell cell;
        std::vector<double> angles;
        double border_all_around = 0.0, border = 0.0;  // see border_of; below 0 until it is asked for
    };

    // How far the disk of point i has to reach; `nearest` gets the around() places next to it.
    Reach reach(std::size_t i, Work& work, std::uint32_t* nearest) const {
        look(i, first_look, work.near);
        for (std::size_t k = 0; k < around(); ++k) nearest[k] = work.near[k].index;
        const double half_way = 0.5 * work.near.front().distance, limit = 2.0 * work.near.back().distance;
        const Vec3 normal = normals_.empty() ? plane_around(distinct_.places, work.near, points_[i]) : normals_[i];
        const Vec3 across = across_line(i, normal, work.near);
        work.border_all_around = border_all_around(i, normal, work.near);
        work.border = -1.0;
        const auto covering = [&](By by) {
            work.cell.start(points_[i], normal, limit);
            const Met met = cut(i, normal, by, work);
            // Most corners are nearer than any border can be.
            const double most = work.border_all_around;
            const bool closed = work.cell.farthest() <= least_share * most;
            return std::pair(work.cell.covering_radius(closed ? most : border_of(i, normal, work)), met);
        };
        auto [own, met] = covering(By::own_sheet_to_edges);
        if (length_squared(across) > 0.0) {
            const double to_lines = reach_to_lines(i, normal, across, work);
            own = met.crease ? std::max(own, to_lines) : to_lines;
            return {own > 0.0 ? own : half_way, own > 0.0 ? own : half_way};
        }
        // Where surfaces are rough, what seems an edge may be none.
        if (met.crease) own = std::max(own, covering(By::own_sheet).first);
        if (!met.other_sheet && own > 0.0) return {own, own};
        double all = covering(By::all).first;
        if (!(all > 0.0)) all = half_way;  // straight above and below
        return {own > 0.0 ? own : all, all};
    }

private:
    static const std::vector<Vec3>& checked(const std::vector<Vec3>& places) {
        require(places.size() >= 2, "radii: all points coincide; give radii");
        return places;
    }

    void look(std::size_t i, std::size_t count, std::vector<Neighbor>& near) const {
        index_.nearest(points_[i], count + 1, near);
        // Places that differ by rounding alone (sin of pi is no 0) can be at distance 0 all of them: look past these.
        for (std::size_t more = count; near.back().distance == 0.0 && near.size() < places();)
            index_.nearest(points_[i], (more *= 2) + 1, near);
        const auto self =
            std::find_if(near.begin(), near.end(), [&](const Neighbor& n) { return n.index == place(i); });
        near.erase(self != near.end() ? self : near.end() - 1);
    }

    // The direction across the line that neighbours lie along, as those of a scanner that takes many steps along each
    // of its lines do; zero where they lie along none.
    Vec3 across_line(std::size_t i, const Vec3& normal, const std::vector<Neighbor>& near) const {
        const Frame frame = frame_around(normal);
        double uu = 0.0, uv = 0.0, vv = 0.0;
        for (const Neighbor& n : near) {
            const Vec3 d = distinct_.places[n.index] - points_[i];
            const double u = dot(d, frame.u), v = dot(d, frame.v);
            uu += u * u;
            uv += u * v;
            vv += v * v;
        }
        // The product of the variances along and across, over the square of their sum.
        if (!(uu * vv - uv * uv < slender * slender * (uu + vv) * (uu + vv))) return {};
        const double along = 0.5 * std::atan2(2.0 * uv, uu - vv);
        return std::cos(along) * frame.v - std::sin(along) * frame.u;
    }

    // How far the disk of a point in a line has to reach to the lines beside it; where there are none, as on a wire, to
    // its neighbours.
    double reach_to_lines(std::size_t i, const Vec3& normal, const Vec3& across, Work& work) const {
        const double next = work.near[std::min<std::size_t>(1, work.near.size() - 1)].distance;
        for (std::size_t count = second_look;; count *= 2) {
            look(i, count, work.near);
            work.cell.start(points_[i], normal, 2.0 * work.near.back().distance);
            double apart = 0.0;
            for (const Neighbor& n : work.near) {
                if (n.distance > 2.0 * work.cell.farthest()) break;
                const Vec3 d = distinct_.places[n.index] - points_[i];
                const bool is_alike = facing_[n.index] == Vec3{} || dot(facing_[n.index], normal) > same_face;
                if (!is_alike || std::abs(dot(d, normal)) > in_plane * n.distance) continue;
                work.cell.cut(distinct_.places[n.index]);
                if (apart == 0.0 && std::abs(dot(d, across)) > beside * n.distance) apart = n.distance;
            }
            if (work.near.back().distance > 2.0 * work.cell.farthest() || count >= last_look || count >= places())
                return work.cell.covering_radius(apart > 0.0 ? between_lines * apart : next);
        }
    }

    // How far a corner of the cell is from the point at most, unless that is on a border: as if there were neighbours
    // all around.
    double border_all_around(std::size_t i, const Vec3& normal, const std::vector<Neighbor>& near) const {
        constexpr double copies = 40.0;  // as much nearer are copies of a place, rounded or shaken, and no piece
        if (near.size() < twelfth || near.back().distance > copies * near[twelfth - 1].distance)
            return std::numeric_limits<double>::infinity();
        std::size_t count = 0;
        double reached = 0.0;
        for (std::size_t k = 0; k < near.size() && count < twelfth; ++k)
            if (stands_as_high(i, normal, near[k])) ++count, reached = near[k].distance;
        const double most = near[twelfth - 1].distance;
        if (count < ring) return beyond * most;
        return beyond * std::min(most, reached * std::sqrt(static_cast<double>(twelfth) / static_cast<double>(count)));
    }

    bool stands_as_high(std::size_t i, const Vec3& normal, const Neighbor& n) const {
        return std::abs(dot(distinct_.places[n.index] - points_[i], normal)) <= as_high * n.distance;
    }

    // The same by the share of directions that there are neighbours in.
    double border_of(std::size_t i, const Vec3& normal, Work& work) const {
        if (work.border >= 0.0) return work.border;
        work.border = work.border_all_around;
        const Frame frame = frame_around(normal);
        std::vector<double>& angles = work.angles;
        angles.clear();
        for (std::size_t k = 0; k < std::min(first_look, work.near.size()) && angles.size() < twelfth; ++k) {
            if (!stands_as_high(i, normal, work.near[k])) continue;
            const Vec3 d = distinct_.places[work.near[k].index] - points_[i];
            angles.push_back(std::atan2(dot(d, frame.v), dot(d, frame.u)));
        }
        if (angles.size() < ring) return work.border;
        std::sort(angles.begin(), angles.end());
        double gap = angles.front() + 2.0 * pi - angles.back();
        for (std::size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
        return work.border *= std::sqrt(1.0 - std::max(0.0, gap - usual_gap) / (2.0 * pi));
    }

    // Cuts the cell by neighbours that do not face the other way, those around a crease at its edge or like the others;
    // or by all.
    enum class By { own_sheet_to_edges, own_sheet, all };
    struct Met {
        bool other_sheet = false, crease = false;
    };

    Met cut(std::size_t i, const Vec3& normal, By by, Work& work) const {
        Met met;
        std::size_t done = 0;
        for (const std::size_t count : {first_look, second_look}) {
            if (done > 0 && count > work.near.size()) look(i, count, work.near);
            for (; done < work.near.size(); ++done) {
                const Neighbor& n = work.near[done];
                if (n.distance > 2.0 * work.cell.farthest()) return met;
                const double cosine = dot(facing_[n.index], normal);
                const Vec3& other = distinct_.places[n.index];
                if (by != By::all && cosine < -same_face) {
                    met.other_sheet = true;
                } else if (cosine < -same_face) {
                    work.cell.cut(other);
                } else if (by != By::own_sheet_to_edges || cosine > same_face || facing_[n.index] == Vec3{}) {
                    cut_up_to_steps(i, normal, n, work);
                } else {
                    met.crease = true;
                    cut_around_crease(points_[i], normal, other, facing_[n.index], work.cell);
                }
            }
        }
        return met;
    }

    // What is seen beside the point, but farther above or below it than beside, is no more of its own surface where
    // that would reach it only over a gap: the surface ends before it, and corners there are open.
    void cut_up_to_steps(std::size_t i, const Vec3& normal, const Neighbor& n, Work& work) const {
        const Vec3& other = distinct_.places[n.index];
        const double over = dot(other - points_[i], normal), squared = n.distance * n.distance;
        if (2.0 * over * over <= squared) return work.cell.cut(other);
        const double aside = std::sqrt(std::max(0.0, squared - over * over));
        const double gap = surely_beyond * border_of(i, normal, work);
        if (aside > gap)
            work.cell.cut_open(other - over * normal);
        else if (squared > 2.0 * aside * gap)  // half way, along the plane
            work.cell.cut_open(other);
        else
            work.cell.cut(other);
    }

    // Around a crease a disk has to reach the edge, where the other's plane meets its own. Where the two do not form an
    // edge, they share what is between them.
    static void cut_around_crease(const Vec3& point, const Vec3& normal, const Vec3& other, const Vec3& facing,
                                  TangentCell& cell) {
        const Vec3 d = other - point;
        const double over = dot(d, normal), under = dot(d, facing);  // of the other's plane over the point
        const Vec3 across = facing - dot(facing, normal) * normal;
        const Vec3 to_edge = across * (under / length_squared(across));
        if (over * under < 0.0 && length_squared(to_edge) > 1e-12 * length_squared(d))
            cell.cut_at_crease(point + 2.0 * to_edge);
        else
            cell.cut(other);
    }

    const std::vector<Vec3>&points_, &normals_;
    DistinctPlaces distinct_;
    std::vector<Vec3> facing_;
    PointIndex index_;
};

}  // namespace

std::vector<double> estimate_radii(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                                   const Progress& progress) {
    require(points.size() >= 2, "radii: wanted at least 2 points to estimate them from, got ", points.size(),
            "; give radii");
    require(normals.empty() || normals.size() == points.size(), "normals: wanted as many as points, ", points.size(),
            ", got ", normals.size());
    const RadiusEstimate estimate(points, normals, progress);
    const std::size_t around = estimate.around();
    std::vector<Reach> reach(points.size());
    std::vector<std::uint32_t> nearest(points.size() * around);
    parallel_blocks(
        points.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            RadiusEstimate::Work work;
            for (std::size_t i = begin; i < end; ++i) reach[i] = estimate.reach(i, work, &nearest[i * around]);
        },
        progress);
    std::vector<double> of_place(estimate.places());
    for (std::size_t i = points.size(); i-- > 0;) of_place[estimate.place(i)] = reach[i].own;
    std::vector<double> radii(points.size());
    parallel_blocks(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        std::vector<double> theirs(around);
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 0; k < around; ++k) theirs[k] = of_place[nearest[i * around + k]];
            const auto third = theirs.begin() + static_cast<std::ptrdiff_t>(std::min(modest, around / 2));
            std::nth_element(theirs.begin(), third, theirs.end());
            radii[i] = margin * std::min({reach[i].own, std::max(reach[i].all, own_sheet_ratio * *third),
                                          outlier_ratio * *third});
        }
    });
    return radii;
}

}  // namespace surflux
