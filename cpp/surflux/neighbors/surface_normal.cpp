#include "surflux/neighbors/surface_normal.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace surflux {

Vec3 SurfaceNormal::operator()(const std::vector<Neighbor>& group) {
    weigh(group);
    const Vec3 flat = plane(group);
    if (!(length_squared(flat) > 0.0)) return {};
    Vec3 sum = quadric(group, flat).normal();
    if (!noisy_) sum += star(group, flat);
    return normalized(sum);  // both lie on the side of `flat`
}

double SurfaceNormal::misfit(const std::vector<Neighbor>& group) {
    weigh(group);
    const Vec3 flat = plane(group);
    if (!(length_squared(flat) > 0.0)) return 0.0;
    weights_[0] = 0.0;
    const Quadric q = quadric(group, flat);
    return std::abs(q.height) * q.unit / spacing_[group[0].index];
}

// Gaussian weights over the nearer three quarters, times the area that each place stands for.
void SurfaceNormal::weigh(const std::vector<Neighbor>& group) {
    weights_.clear();
    const std::size_t used = std::min(group.size(), std::max<std::size_t>(4, group.size() * 3 / 4));
    reach_ = used > 0 ? group[std::min(used, group.size() - 1)].distance : 0.0;
    if (!(reach_ > 0.0)) return;
    for (std::size_t k = 0; k < used; ++k) {
        const double x = group[k].distance / reach_, side = spacing_[group[k].index] / reach_;
        weights_.push_back(side * side * std::exp((noisy_ ? -3.0 : -6.0) * x * x));
    }
}

Vec3 SurfaceNormal::plane(const std::vector<Neighbor>& group) {
    breadth_ = 0.0;
    Vec3 mean;
    double total = 0.0;
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        mean += weights_[k] * (places_[group[k].index] - places_[group[0].index]);
        total += weights_[k];
    }
    if (!(total > 0.0)) return {};
    mean = places_[group[0].index] + mean / total;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        const Vec3 d = places_[group[k].index] - mean;
        const Eigen::Vector3d e(d.x, d.y, d.z);
        covariance += weights_[k] * e * e.transpose();
    }
    const double scale = covariance.trace();
    if (!(scale > 0.0)) return {};
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / scale);
    if (solver.eigenvalues()[1] < 1e-9) return {};
    breadth_ = (solver.eigenvalues()[1] - 3.0 * solver.eigenvalues()[0]) / solver.eigenvalues()[2];
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    return normalized({n[0], n[1], n[2]});
}

// Least squares of the heights over the plane through the place.
SurfaceNormal::Quadric SurfaceNormal::quadric(const std::vector<Neighbor>& group, const Vec3& n) const {
    using Row = Eigen::Matrix<double, 6, 1>;
    const Frame frame = frame_around(n);
    Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Zero();
    Row b = Row::Zero();
    double total = 0.0;
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        const Vec3 d = (places_[group[k].index] - places_[group[0].index]) / reach_;
        const double u = dot(d, frame.u), v = dot(d, frame.v);
        Row row;
        row << 1.0, u, v, u * u, u * v, v * v;
        a += weights_[k] * row * row.transpose();
        b += weights_[k] * dot(d, n) * row;
        total += weights_[k];
    }
    // A little weight on flatness decides what too few or badly placed neighbours leave open.
    Row ridge;
    ridge << 1e-6, 1e-6, 1e-6, 3e-3, 3e-3, 3e-3;
    a.diagonal() += total * ridge;
    const Row x = a.ldlt().solve(b);
    return {x[0], x[1], x[2], frame, reach_};
}

// The Delaunay neighbours of the origin are the convex hull of the points inverted at the unit circle.
Vec3 SurfaceNormal::star(const std::vector<Neighbor>& group, const Vec3& n) {
    // Of reach_. Copies of the place that are rounded otherwise, and points beside it by chance, lie in any direction,
    // and triangles with them would span half of all around.
    constexpr double nearest = 0.08;
    // Sine of the angle between spokes on either side of an open border. Where it is straight, their plane is noise: at
    // 1e-6 half of the border of a grid was off by 22 degrees, at .1 to .3 none, and creases lose 1 % or less.
    constexpr double opposite = 0.2;
    const Frame frame = frame_around(n);
    spokes_.clear();
    for (std::size_t k = 1; k < group.size(); ++k) {
        const Vec3 d = (places_[group[k].index] - places_[group[0].index]) / reach_;
        const double u = dot(d, frame.u), v = dot(d, frame.v), flat = std::hypot(u, v);
        // As far away as it is in space: what rises steeply from the plane is no near neighbour.
        const double away = length(d);
        if (away > nearest && flat > 1e-6 * away) spokes_.push_back({u / (flat * away), v / (flat * away), d});
    }
    if (spokes_.size() < 3) return n;
    std::sort(spokes_.begin(), spokes_.end(),
              [](const Spoke& a, const Spoke& b) { return a.u != b.u ? a.u < b.u : a.v < b.v; });
    const auto turn = [](const Spoke& o, const Spoke& a, const Spoke& b) {
        return (a.u - o.u) * (b.v - o.v) - (a.v - o.v) * (b.u - o.u);
    };
    hull_.clear();  // counter-clockwise, by Andrew's monotone chain; the first comes again at the end
    for (const Spoke& s : spokes_) {
        while (hull_.size() >= 2 && turn(hull_[hull_.size() - 2], hull_.back(), s) <= 0.0) hull_.pop_back();
        hull_.push_back(s);
    }
    const std::size_t lower = hull_.size() + 1;
    for (std::size_t k = spokes_.size() - 1; k-- > 0;) {
        while (hull_.size() >= lower && turn(hull_[hull_.size() - 2], hull_.back(), spokes_[k]) <= 0.0)
            hull_.pop_back();
        hull_.push_back(spokes_[k]);
    }
    Vec3 sum;
    for (std::size_t k = 0; k + 1 < hull_.size(); ++k) {
        const Spoke &a = hull_[k], &b = hull_[k + 1];
        // The far side of an open border.
        if (!(a.u * b.v - a.v * b.u > opposite * std::hypot(a.u, a.v) * std::hypot(b.u, b.v))) continue;
        const Vec3 c = cross(a.d, b.d);
        const double size = length(c);
        if (size > 0.0) sum += std::atan2(size, dot(a.d, b.d)) / size * c;
    }
    if (!(length_squared(sum) > 0.0)) return n;
    return normalized(dot(sum, n) < 0.0 ? -sum : sum);
}

}  // namespace surflux
