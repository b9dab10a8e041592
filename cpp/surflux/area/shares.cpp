#include "surflux/area/shares.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/area/disk_integrator.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/error.h"
#include "surflux/neighbors/disk_kernel.h"

namespace surflux {

namespace {

// D04 eq. 6, at the point of disk j's plane over (x, y).
double paper_weight(const Member& j, double kappa, double x, double y) {
    Vec3 d{x - j.position.x, y - j.position.y, 0.0};
    d.z = -(d.x * j.normal.x + d.y * j.normal.y) / j.normal.z;
    const double r = length(d) / j.radius;
    return r <= 1.0 ? std::exp(-kappa * r) : 0.0;
}

// Over that of the surfel itself, which may be infinite; see effective_area.h.
double curved_weight(const Member& j, double kappa, const Vec3& p, double own_square) {
    return disk_weight(length_squared(p - j.position), j.radius * j.radius, own_square, 1e-9, kappa);
}

bool inside(const std::vector<HalfPlane>& ends, double x, double y) {
    return x * x + y * y <= 1.0 &&
           std::none_of(ends.begin(), ends.end(), [&](const HalfPlane& h) { return h.x * x + h.y * y > h.limit; });
}

}  // namespace

DiskShares area_shares(const Surfels& surfels, std::size_t index, const AreaOptions& options) {
    check(options);
    require(index < surfels.size(), "index: wanted below ", surfels.size(), ", the number of surfels, got ", index);
    const std::vector<bool> is_disk = disks_among(surfels);
    require(is_disk[index], "index: surfel ", index, " is a patch of a mesh, whose area is exact, and has no disk");

    const bool curved = options.method == AreaMethod::curved;
    const NeighborhoodFinder finder(surfels, is_disk, options.epsilon);
    Neighborhood around;
    std::size_t disk = 0;
    const auto is_in = [&](Span<std::uint32_t> pile) {
        return std::find(pile.begin(), pile.end(), index) != pile.end();
    };
    while (!is_in(finder.surfels(disk))) ++disk;
    finder.find(disk, curved, around);
    std::vector<Member> members = around.surface;
    if (curved) members.insert(members.end(), around.crease.begin(), around.crease.end());

    const auto n = static_cast<std::size_t>(options.resolution);
    DiskShares out{around.frame,
                   around.radius,
                   DiskIntegrator(options, PolarGrid(options.resolution)).area(around) /
                       static_cast<double>(finder.surfels(disk).size()),
                   options.resolution,
                   {},
                   {}};
    for (const Member& m : members) out.members.push_back(m.surfel);
    out.shares.assign(members.size() * n * n, std::numeric_limits<double>::quiet_NaN());
    std::vector<double> weights(members.size());
    for (std::size_t pixel = 0; pixel < n * n; ++pixel) {
        const auto center = [n](std::size_t k) {
            return -1.0 + (2.0 * static_cast<double>(k) + 1.0) / static_cast<double>(n);
        };
        const double x = center(pixel % n), y = center(pixel / n);
        if (!inside(around.ends, x, y)) continue;
        double sum = 0.0;
        if (curved) {
            const Vec3 p{x, y, around.model.height(x, y)};
            const double own = length_squared(p - members[0].position);
            for (std::size_t k = 0; k < members.size(); ++k) {
                weights[k] = k == 0 ? std::max(1.0 - own, 0.0) : curved_weight(members[k], options.kappa, p, own);
                sum += weights[k];
            }
        } else {
            for (std::size_t k = 0; k < members.size(); ++k)
                sum += weights[k] = paper_weight(members[k], options.kappa, x, y);
        }
        if (!(sum > 0.0)) continue;
        for (std::size_t k = 0; k < members.size(); ++k) out.shares[k * n * n + pixel] = weights[k] / sum;
    }
    return out;
}

}  // namespace surflux
