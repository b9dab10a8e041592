#include "surflux/neighbors/plane_fit.h"

#include <Eigen/Eigenvalues>

namespace surflux {

Vec3 plane_normal(const std::vector<Vec3>& points, const std::vector<Neighbor>& group) {
    Vec3 mean;
    for (const Neighbor& n : group) mean += points[n.index];
    mean *= 1.0 / static_cast<double>(group.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Neighbor& n : group) {
        const Vec3 d = points[n.index] - mean;
        const Eigen::Vector3d e(d.x, d.y, d.z);
        covariance += e * e.transpose();
    }
    const double scale = covariance.trace();
    if (!(scale > 0.0)) return {};
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / scale);
    if (solver.eigenvalues()[1] < 1e-12) return {};
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    return normalized({n[0], n[1], n[2]});
}

}  // namespace surflux
