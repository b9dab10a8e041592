#include "surflux/solution/nodal_field.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/solution/slope_fit.h"

namespace surflux {

NodalField::NodalField(std::vector<Vec3> positions, std::vector<Vec3> normals, std::vector<std::uint32_t> objects,
                       const Progress& progress, const NodalTuning& tuning)
    : positions_(std::move(positions)), normals_(std::move(normals)), objects_(std::move(objects)), tuning_(tuning) {
    for (const Vec3& normal : normals_) frames_.push_back(frame_around(normal));
    interpolation_ = std::make_unique<Interpolation>(positions_, normals_, objects_, progress);
    sites_ = std::make_unique<Sight::Sites>(positions_, normals_);
}

Rgb NodalField::turned(const Values& field, std::uint32_t k, const Vec3& normal) const {
    const TiltedRgb& f = field.values[k];
    if (!field.tilted) return f.value;
    const Frame& frame = frames_[k];
    Rgb out = f.value + dot(normal, frame.u) * f.u + dot(normal, frame.v) * f.v;
    for (int c = 0; c < 3; ++c) {
        const double value = std::max(0.0, f.value[c]);
        out[c] = std::clamp(out[c], tuning_.least_turn * value, tuning_.most_turn * value);
    }
    return out;
}

NodalField::Values NodalField::fit(std::vector<TiltedRgb> values, const Sight* sight, const Progress& progress) const {
    Values out{std::move(values), {}, true};
    fit_slopes(out, sight, progress);
    return out;
}

NodalField::Values NodalField::fit(const std::vector<Rgb>& values, const Sight* sight, const Progress& progress) const {
    Values out{std::vector<TiltedRgb>(size()), {}, false};
    for (std::size_t k = 0; k < values.size(); ++k) out.values[k].value = values[k];
    fit_slopes(out, sight, progress);
    return out;
}

void NodalField::fit_slopes(Values& out, const Sight* sight, const Progress& progress) const {
    out.slopes.assign(size(), {});
    const std::size_t slope_neighbors = whole_number(tuning_.slope_neighbors);
    parallel_blocks(
        size(), 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = begin; k < end; ++k) {
                const auto i = static_cast<std::uint32_t>(k);
                interpolation_->nearest(positions_[i], normals_[i], objects_[i], slope_neighbors, near);
                if (near.size() < 4) continue;
                const double h = near.back().weight;
                SlopeFit<Rgb> fit;
                for (const Interpolation::Weight& other : near) {
                    if (other.site == i || !(other.weight > 0.0)) continue;
                    if (sight && differ_much(out.values[other.site].value, out.values[i].value) &&
                        !sight->joined(sites_->place(*sight, i), sites_->place(*sight, other.site)))
                        continue;
                    const Vec3 d = positions_[other.site] - positions_[i];
                    const double x = dot(d, frames_[i].u), y = dot(d, frames_[i].v);
                    const double w = 1.0 / (length_squared(d) + 0.01 * h * h);
                    const Rgb rise = turned(out, other.site, normals_[i]) - out.values[i].value;
                    fit.add(x, y, w, rise);
                }
                fit.solve(out.slopes[i].u, out.slopes[i].v);  // else it stays 0
            }
        },
        progress);
}

Rgb NodalField::at(const Values& field, const Vec3& point, const Vec3& normal,
                   Span<Interpolation::Weight> weights) const {
    if (weights.empty()) return {};
    Rgb sum, least = {1e300, 1e300, 1e300}, most;
    for (const Interpolation::Weight& w : weights) {
        const Vec3 d = point - positions_[w.site];
        const Slope& slope = field.slopes[w.site];
        const Rgb level = turned(field, w.site, normal);
        sum += w.weight * (level + dot(d, frames_[w.site].u) * slope.u + dot(d, frames_[w.site].v) * slope.v);
        for (int c = 0; c < 3; ++c) {
            least[c] = std::min(least[c], level[c]);
            most[c] = std::max(most[c], level[c]);
        }
    }
    // Slopes may carry on a little beyond what the nodes around have. Where all are lit, no place is dark.
    for (int c = 0; c < 3; ++c) {
        const double spare = tuning_.spare_share * (most[c] - least[c]);
        sum[c] = std::clamp(sum[c], std::max(tuning_.least_share * least[c], least[c] - spare), most[c] + spare);
    }
    return sum;
}

std::vector<Rgb> NodalField::at_conservatively(const Values& field, std::size_t places,
                                               const std::function<Place(std::size_t)>& place,
                                               const Progress& progress) const {
    const auto constant = [&](const Place& of) {
        Rgb sum;
        for (const Interpolation::Weight& w : of.weights) sum += w.weight * field.values[w.site].value;
        for (int c = 0; c < 3; ++c) sum[c] = std::max(0.0, sum[c]);
        return sum;
    };
    const double most_sloped = tuning_.most_sloped;
    std::vector<Rgb> out(places);
    parallel_for(
        places, 256,
        [&](std::size_t p) {
            const Place of = place(p);
            const Rgb level = constant(of);
            out[p] = at(field, of.position, of.normal, of.weights);
            for (int c = 0; c < 3; ++c)
                out[p][c] = std::clamp(out[p][c], level[c] / most_sloped, most_sloped * level[c]);
        },
        progress);
    // Around each node, what weights say and what was found.
    struct Sums {
        Rgb wanted, found;
        void operator+=(const Sums& other) { wanted += other.wanted, found += other.found; }
    };
    std::vector<Sums> sums(size());
    const auto add = [&](std::size_t p, std::vector<Sums>& to) {
        const Place of = place(p);
        const Rgb level = constant(of);
        for (const Interpolation::Weight& w : of.weights) {
            to[w.site].wanted += (of.area * w.weight) * level;
            to[w.site].found += (of.area * w.weight) * out[p];
        }
    };
    parallel_scatter(places, sums, add, progress);
    std::vector<Rgb> scale(size());
    for (std::size_t k = 0; k < size(); ++k)
        for (int c = 0; c < 3; ++c) scale[k][c] = sums[k].found[c] > 0.0 ? sums[k].wanted[c] / sums[k].found[c] : 1.0;
    parallel_for(
        places, 256,
        [&](std::size_t p) {
            const Place of = place(p);
            Rgb all;
            for (const Interpolation::Weight& w : of.weights) all += w.weight * scale[w.site];
            out[p] = all * out[p];
        },
        progress);
    return out;
}

}  // namespace surflux
