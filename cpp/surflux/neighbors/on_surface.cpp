#include "surflux/neighbors/on_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double along = 2.0, off = 1.0;  // radii
constexpr double corner = 1.0 + 1e-9;     // which is on the patch

std::vector<double> along_of(const std::vector<double>& radii, const std::vector<double>& extents) {
    std::vector<double> out;
    for (const double r : radii) out.push_back(along * r);
    for (std::size_t k = 0; k < extents.size(); ++k) out[k] = std::max(out[k], corner * extents[k]);
    return out;
}

std::vector<double> reaches_of(const std::vector<double>& radii, const std::vector<double>& along_each) {
    std::vector<double> out;
    for (std::size_t k = 0; k < radii.size(); ++k) out.push_back(corner * std::hypot(off * radii[k], along_each[k]));
    return out;
}

}  // namespace

OnSurface::OnSurface(std::vector<Vec3> centers, std::vector<Vec3> normals, std::vector<double> radii,
                     const std::vector<double>& extents)
    : centers_(std::move(centers)),
      normals_(std::move(normals)),
      radii_(std::move(radii)),
      along_(along_of(radii_, extents)),
      disks_(centers_, reaches_of(radii_, along_)) {}

std::vector<char> OnSurface::operator()(const std::vector<Vec3>& points, const std::vector<Vec3>& facing) const {
    std::vector<char> out(points.size());
    parallel_blocks(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            near.clear();
            disks_.reaching(points[k], 0.0, near);
            out[k] = std::any_of(near.begin(), near.end(), [&](const Neighbor& n) {
                const double height = dot(points[k] - centers_[n.index], normals_[n.index]);
                const double squared = n.distance * n.distance - height * height;
                return std::abs(height) <= off * radii_[n.index] && squared <= along_[n.index] * along_[n.index] &&
                       dot(facing[k], normals_[n.index]) > 0.0;
            });
        }
    });
    return out;
}

}  // namespace surflux
