#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "surflux/lights/sample_points.h"
#include "surflux/radiosity/polygon_exchange.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/extent.h"
#include "surflux/scene/scene.h"

namespace surflux {

// The geometric part of the exchange between two surfels, G_ij = A_i F_ij without visibility: symmetric, >= 0, and
// robust however close the two are.
//   far   (r > 10 s)   the kernel of D04 eq. 2 between the centres
//   mid   (r > 3.5 s)  the same kernel between small quadratures of both surfels
//   near               element-to-polygon closed form, integrated over either surfel, and the two averaged
// with s the larger of both extents. Two patches have the small quadratures from 10 s to 40 s, and the contour integral
// of their polygons (polygon_exchange.h) up to 10 s, exact to some 1e-7. Disks that overlap on the same
// surface are neighbours, not partners that face each other: the kernel, kept finite.
class PairExchange {
public:
    // Surfaces that rays cannot tell apart touch, or (`by_rays` off) those that doubles cannot.
    explicit PairExchange(const Scene& scene, double epsilon = 0.8, bool by_rays = true,
                          const PairsTuning& tuning = {});

    enum class Range { none, same_surface, far, mid, near };
    struct Pair {
        double exchange = 0.0;
        Range range = Range::none;
    };
    Pair operator()(std::uint32_t i, std::uint32_t j) const;

    // The same where it may take longer: of two patches to some 1e-9 of it at any distance.
    Pair precise(std::uint32_t i, std::uint32_t j) const;

    // G_ii of a concave piece: its own area times the mean kernel to its nearest surroundings; 0 where flat or convex.
    double self(std::uint32_t i, const std::vector<std::uint32_t>& overlapping) const;

    // cos cos / (pi r^2) between a point of each.
    double kernel(std::uint32_t i, const Vec3& at_i, std::uint32_t j, const Vec3& at_j) const;

    // Where a ray from in front of surfel j meets its patch, or the disk of its area.
    bool meets(std::uint32_t j, const Vec3& from, const Vec3& direction, Vec3& at) const;

    bool is_patch(std::uint32_t i) const { return points_.is_patch(i); }
    // A surfel that emits in a scene where few do: much depends on each pair that it belongs to.
    bool is_lamp(std::uint32_t i) const { return few_emit_ && emits(i); }
    const Vec3& normal(std::uint32_t i) const { return scene_.surfels.normals[i]; }
    double extent(std::uint32_t i) const { return extent_[i]; }

    // A point of the surfel for a visibility ray of a pair at that range.
    Vec3 ray_point(std::uint32_t i, Range range, double s, double t) const;

private:
    using Octagon = std::array<Vec3, 8>;

    bool emits(std::uint32_t i) const { return !(scene_.surfels.emission[i] == Rgb{}); }
    double kernel(const Vec3& x_i, const Vec3& n_i, const Vec3& x_j, const Vec3& n_j) const;
    double near_factor(std::uint32_t i, std::uint32_t j) const;
    double near_factor_of_triangles(std::uint32_t i, std::uint32_t j) const;
    double near_factor_of_disk(std::uint32_t i, std::uint32_t j) const;
    double between_nodes(std::uint32_t i, std::uint32_t j) const;
    double between_polygons(std::uint32_t i, std::uint32_t j, int count, Grading grading = Grading::graded) const;
    bool rise_above_each_other(std::uint32_t i, std::uint32_t j) const;
    bool face_wholly(std::uint32_t i, std::uint32_t j) const;
    template <int count>
    double by_quadrature(std::uint32_t i, std::uint32_t j) const;
    double to_polygons(std::uint32_t i, const Vec3& point, std::uint32_t j) const;
    Octagon octagon_of_disk(std::uint32_t i) const;
    bool same_surface(std::uint32_t i, std::uint32_t j, double squared) const;
    bool is_back_of_neighbor(std::uint32_t i, std::uint32_t j, double squared) const;

    const Scene& scene_;
    double epsilon_;
    double mid_ratio_, far_ratio_, patches_far_ratio_;  // PairsTuning
    SurfelPoints points_;
    // What is closer than this to a surfel's plane covers it instead of exchanging light with it.
    double contact(std::uint32_t i, std::uint32_t j) const {
        return touch_ * std::max(distances_.contact_of(i), distances_.contact_of(j));
    }
    Extent distances_;
    double touch_;
    bool few_emit_ = false;
    std::vector<std::uint32_t> backs_;  // twins (trace/coincident.h)
    std::vector<double> counted_;  // of a patch's triangles, the share that is its area: less where others cover it
    std::vector<double> extent_;   // farthest corner of the patch; radius of the disk of area S
    std::vector<std::uint32_t> node_begin_;
    std::vector<Vec3> nodes_;                     // quadrature of the mid range
    std::vector<double> node_weight_;             // sums to 1 over the nodes of each surfel
    std::vector<std::vector<Polygon>> polygons_;  // of patches: a parallelogram, or triangles
};

}  // namespace surflux
