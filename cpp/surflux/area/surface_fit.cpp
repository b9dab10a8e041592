#include "surflux/area/surface_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

// Nearer than this, in units of the disk, a point tells about heights, no longer about slopes.
constexpr double shortest_chord = 0.5;
// Keeps what the points leave open (K, with fewer than three neighbours) at zero; far below what they determine.
constexpr double ridge = 1e-6;

struct Tangential {
    double x, y, z;
};

Tangential normal_at(const SurfaceModel& m, double x, double y) {
    Tangential t{m.gx + m.kxx * x + m.kxy * y, m.gy + m.kxy * x + m.kyy * y, 0.0};
    t.z = std::sqrt(1.0 - std::min(t.x * t.x + t.y * t.y, steepest_normal));
    return t;
}

}  // namespace

double SurfaceModel::height(double x, double y) const {
    const Tangential own = normal_at(*this, 0.0, 0.0), there = normal_at(*this, x, y);
    return z0 - (x * (own.x + there.x) + y * (own.y + there.y)) / (own.z + there.z);
}

double SurfaceModel::stretch(double x, double y) const { return 1.0 / normal_at(*this, x, y).z; }

SurfaceModel fit_surface(const std::vector<OrientedPoint>& points) {
    using Row = Eigen::Matrix<double, 6, 1>;
    Eigen::Matrix<double, 6, 6> normal_matrix = Eigen::Matrix<double, 6, 6>::Zero();
    Row right = Row::Zero();
    const auto add = [&](double weight, const Row& row, double value) {
        normal_matrix.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
        right += weight * value * row;
    };
    Row row;
    // Unknowns: kxx, kxy, kyy, gx, gy, z0. The surfel itself: g = 0, z0 = 0.
    normal_matrix(3, 3) = normal_matrix(4, 4) = 1.0;
    normal_matrix(5, 5) = 4.0;
    for (int k = 0; k < 3; ++k) normal_matrix(k, k) = ridge;
    for (const OrientedPoint& p : points) {
        const auto& [x, y, z] = p.position;
        const Vec3& n = p.normal;
        row << x, y, 0.0, 1.0, 0.0, 0.0;
        add(p.weight, row, n.x);
        row << 0.0, x, y, 0.0, 1.0, 0.0;
        add(p.weight, row, n.y);
        // The chord: (z - z0) (1 + n_z) + (x, y) . (g + t) = 0 with t = g + K (x, y), as a slope.
        const double scale = 1.0 / std::max(std::hypot(x, y), shortest_chord);
        row << x * x, 2.0 * x * y, y * y, 2.0 * x, 2.0 * y, -(1.0 + n.z);
        row *= scale;
        add(p.weight, row, -z * (1.0 + n.z) * scale);
    }
    const Row solved = normal_matrix.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    return {solved[0], solved[1], solved[2], solved[3], solved[4], solved[5]};
}

}  // namespace surflux
