#include "surflux/neighbors/on_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double along = 2.0, off = 1.0;  // radii

}  // namespace

OnSurface::OnSurface(std::vector<Vec3> centers, std::vector<Vec3> normals, std::vector<double> radii)
    : centers_(std::move(centers)), normals_(std::move(normals)), radii_(std::move(radii)), disks_(centers_, radii_) {}

std::vector<char> OnSurface::operator()(const std::vector<Vec3>& points, const std::vector<Vec3>& facing) const {
    std::vector<char> out(points.size());
    const double reach = std::sqrt(along * along + off * off);
    parallel_blocks(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            near.clear();
            disks_.reaching(points[k], 0.0, near, reach);
            out[k] = std::any_of(near.begin(), near.end(), [&](const Neighbor& n) {
                const double r = radii_[n.index];
                const double height = dot(points[k] - centers_[n.index], normals_[n.index]);
                const double squared = n.distance * n.distance - height * height;
                return std::abs(height) <= off * r && squared <= along * along * r * r &&
                       dot(facing[k], normals_[n.index]) > 0.0;
            });
        }
    });
    return out;
}

}  // namespace surflux
