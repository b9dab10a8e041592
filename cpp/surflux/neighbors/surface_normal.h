#pragma once

#include <vector>

#include "surflux/neighbors/point_index.h"

namespace surflux {

// Fits the normal of a surface at one of its points. Holds scratch memory: one per thread.
class SurfaceNormal {
public:
    // `spacing`, per place: the distance to a near neighbour. It makes up for uneven sampling.
    SurfaceNormal(const std::vector<Vec3>& places, const std::vector<double>& spacing, bool noisy = false)
        : places_(places), spacing_(spacing), noisy_(noisy) {}

    // At the place of the first of `group`, from all of them, which stand sorted by distance. The mean of two fits that
    // err differently: a quadric (Cazals and Pouget 2005), and the triangles around the place in a Delaunay
    // triangulation of the tangent plane, each by its angle there (Thuermer and Wuethrich 1998), which look no farther
    // than the next ring and so stay sharp at creases. Of noisy places the quadric alone, over more of the group.
    // Zero where the group spans no plane.
    Vec3 operator()(const std::vector<Neighbor>& group);

    // How broad the last group was for its length, as a ratio of variances, beyond what it scatters across its plane:
    // small where it is little more than a line, or has no plane at all.
    double breadth() const { return breadth_; }

    // How far the place lies off the quadric through the others, in spacings; 0 where they span no plane.
    double misfit(const std::vector<Neighbor>& group);

private:
    struct Quadric {
        double height, slope_u, slope_v;  // at the place, over a plane through it
        Frame frame;
        double unit;  // of height
        Vec3 normal() const { return normalized(frame.n - slope_u * frame.u - slope_v * frame.v); }
    };
    void weigh(const std::vector<Neighbor>& group);
    Vec3 plane(const std::vector<Neighbor>& group);
    Quadric quadric(const std::vector<Neighbor>& group, const Vec3& n) const;
    Vec3 star(const std::vector<Neighbor>& group, const Vec3& n);

    struct Spoke {
        double u, v;  // of the inverted projection
        Vec3 d;
    };
    const std::vector<Vec3>& places_;
    const std::vector<double>& spacing_;
    bool noisy_;
    double reach_ = 0.0, breadth_ = 0.0;
    std::vector<double> weights_;  // of the first of the group
    std::vector<Spoke> spokes_, hull_;
};

}  // namespace surflux
