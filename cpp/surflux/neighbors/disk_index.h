#pragma once

#include <vector>

#include "surflux/neighbors/point_index.h"

namespace surflux {

// Range search for disks of different radii: all whose centre lies closer than r + R_k to a point. One tree per octave
// of radii, so that a few large disks do not make every search large.
class DiskIndex {
public:
    DiskIndex(const std::vector<Vec3>& centers, const std::vector<double>& radii, const Progress& progress = {});

    // Appends to `out` every disk k with |x_k - query| < scale (radius + R_k).
    void reaching(const Vec3& query, double radius, std::vector<Neighbor>& out, double scale = 1.0) const;
    // Appends every disk whose centre is at most `radius` away.
    void centered_within(const Vec3& query, double radius, std::vector<Neighbor>& out) const;

private:
    struct Octave {
        double largest;
        std::vector<std::uint32_t> members;
        PointIndex tree;
    };
    std::vector<Octave> octaves_;
    std::vector<double> radii_;
};

}  // namespace surflux
