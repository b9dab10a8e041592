#include "surflux/area/disk_integrator.h"

namespace surflux {

namespace {

// The geometry of D04 fig. 3b: over y_i = x_i + R_i (s u + t v), y_j = y_i + h n_i with h chosen on disk j's plane.
DiskTerm term_of(const Member& j) {
    const Vec3 d = -1.0 / j.radius * j.position;
    const Vec3& n = j.normal;
    const double step = 1.0 / j.radius;
    const double h0 = -dot(d, n) / n.z, h1 = -step * n.x / n.z, h2 = -step * n.y / n.z;
    // |d + s u + t v + h n_i|^2 with h = h0 + h1 s + h2 t.
    DiskTerm term;
    term.c00 = static_cast<float>(dot(d, d) + 2.0 * h0 * d.z + h0 * h0);
    term.c10 = static_cast<float>(2.0 * d.x * step + 2.0 * h1 * d.z + 2.0 * h0 * h1);
    term.c01 = static_cast<float>(2.0 * d.y * step + 2.0 * h2 * d.z + 2.0 * h0 * h2);
    term.c20 = static_cast<float>(step * step + h1 * h1);
    term.c11 = static_cast<float>(2.0 * h1 * h2);
    term.c02 = static_cast<float>(step * step + h2 * h2);
    term.stretch = static_cast<float>(1.0 / n.z);
    return term;
}

Sharer sharer_of(const Member& j) {
    return {static_cast<float>(j.position.x), static_cast<float>(j.position.y), static_cast<float>(j.position.z),
            static_cast<float>(1.0 / (j.radius * j.radius))};
}

CurvedSurface single_precision(const SurfaceModel& m) {
    return {static_cast<float>(m.kxx), static_cast<float>(m.kxy), static_cast<float>(m.kyy),
            static_cast<float>(m.gx),  static_cast<float>(m.gy),  static_cast<float>(m.z0)};
}

// Where each direction of the grid leaves the disk or one of the half planes.
void ends_along(const std::vector<HalfPlane>& half_planes, const PolarGrid& grid, std::vector<float>& ends) {
    ends.assign(static_cast<std::size_t>(grid.directions), 1.0f);
    for (const HalfPlane& h : half_planes) {
        const auto x = static_cast<float>(h.x), y = static_cast<float>(h.y), limit = static_cast<float>(h.limit);
        for (std::size_t d = 0; d < ends.size(); ++d) {
            const float towards = x * grid.cosine[d] + y * grid.sine[d];
            if (towards * ends[d] > limit) ends[d] = limit / towards;
        }
    }
}

}  // namespace

double DiskIntegrator::area(const Neighborhood& around) {
    const auto kappa = static_cast<float>(options_.kappa);
    double share = 0.0;
    if (options_.method == AreaMethod::paper) {
        terms_.clear();
        for (const Member& j : around.surface) terms_.push_back(term_of(j));
        share = integrate_paper(terms_.data(), terms_.size(), kappa, options_.resolution);
    } else {
        sharers_.clear();
        for (const Member& j : around.surface) sharers_.push_back(sharer_of(j));
        for (const Member& j : around.crease) sharers_.push_back(sharer_of(j));
        const std::size_t first_other = sharers_.size();
        for (const Member& j : around.others) sharers_.push_back(sharer_of(j));
        sharer_ends_.clear();
        for (const MemberEnd& end : around.others_ends)
            sharer_ends_.push_back({static_cast<std::uint32_t>(first_other + end.member),
                                    static_cast<float>(end.normal.x), static_cast<float>(end.normal.y),
                                    static_cast<float>(end.normal.z), static_cast<float>(end.limit)});
        ends_along(around.ends, grid_, ends_);
        share = integrate_curved(single_precision(around.model), sharers_.data(), sharers_.size(), ends_.data(), kappa,
                                 grid_, sharer_ends_.data(), sharer_ends_.size());
    }
    return around.radius * around.radius * share;
}

}  // namespace surflux
