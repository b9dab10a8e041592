#include "surflux/radiosity/nodal_field.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t slope_neighbors = 9;  // itself among them
constexpr double stiffness = 0.1;           // of the fit, against slopes that neighbours on one line do not give

}  // namespace

NodalField::NodalField(std::vector<Place> receivers, std::vector<std::uint32_t> objects)
    : receivers_(std::move(receivers)), objects_(std::move(objects)) {
    for (const Place& r : receivers_) {
        positions_.push_back(r.position);
        normals_.push_back(r.normal);
        frames_.push_back(frame_around(r.normal));
    }
    interpolation_ = std::make_unique<Interpolation>(positions_, normals_, objects_);
}

Rgb NodalField::turned(const TiltedRgb& f, std::uint32_t k, const Vec3& normal) const {
    const Frame& frame = frames_[k];
    Rgb out = dot(normal, frame.n) * f.value + dot(normal, frame.u) * f.u + dot(normal, frame.v) * f.v;
    for (int c = 0; c < 3; ++c) out[c] = std::clamp(out[c], 0.3 * f.value[c], 3.0 * f.value[c]);
    return out;
}

NodalField::Values NodalField::fit(std::vector<TiltedRgb> values) const {
    Values out{std::move(values), std::vector<Slope>(size())};
    parallel_blocks(size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<Interpolation::Weight> near;
        for (std::size_t k = begin; k < end; ++k) {
            const auto i = static_cast<std::uint32_t>(k);
            interpolation_->nearest(positions_[i], normals_[i], objects_[i], slope_neighbors, near);
            if (near.size() < 4) continue;
            const double h = near.back().weight;
            double uu = 0.0, uv = 0.0, vv = 0.0;
            Rgb u, v;
            for (const Interpolation::Weight& other : near) {
                if (other.site == i || !(other.weight > 0.0)) continue;
                const Vec3 d = positions_[other.site] - positions_[i];
                const double x = dot(d, frames_[i].u), y = dot(d, frames_[i].v);
                const double w = 1.0 / (length_squared(d) + 0.01 * h * h);
                const Rgb rise = turned(out.values[other.site], other.site, normals_[i]) - out.values[i].value;
                uu += w * x * x;
                uv += w * x * y;
                vv += w * y * y;
                u += (w * x) * rise;
                v += (w * y) * rise;
            }
            const double ridge = stiffness * 0.5 * (uu + vv);
            uu += ridge;
            vv += ridge;
            const double determinant = uu * vv - uv * uv;
            if (!(determinant > 0.0)) continue;
            out.slopes[i] = {(vv * u - uv * v) / determinant, (uu * v - uv * u) / determinant};
        }
    });
    return out;
}

Rgb NodalField::at(const Values& field, const Vec3& point, const Vec3& normal,
                   const std::vector<Interpolation::Weight>& weights) const {
    Rgb sum, least = {1e300, 1e300, 1e300}, most;
    for (const Interpolation::Weight& w : weights) {
        const Vec3 d = point - positions_[w.site];
        const Slope& slope = field.slopes[w.site];
        const Rgb level = turned(field.values[w.site], w.site, normal);
        sum += w.weight * (level + dot(d, frames_[w.site].u) * slope.u + dot(d, frames_[w.site].v) * slope.v);
        for (int c = 0; c < 3; ++c) {
            least[c] = std::min(least[c], level[c]);
            most[c] = std::max(most[c], level[c]);
        }
    }
    // Slopes may carry on a little beyond what the nodes around have, and not to below nothing.
    for (int c = 0; c < 3; ++c) {
        const double spare = 0.25 * (most[c] - least[c]);
        sum[c] = std::clamp(sum[c], std::max(0.0, least[c] - spare), most[c] + spare);
    }
    return sum;
}

}  // namespace surflux
