#include "surflux/solution/residuals.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/morton.h"
#include "surflux/solution/gmres.h"

namespace surflux {

namespace {

constexpr double coarse_tolerance = 1e-9;
constexpr int most_applications = 1000;

// Which way a normal points mostly: one of the six axes.
int main_direction(const Vec3& n) {
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    if (x >= y && x >= z) return n.x > 0.0 ? 0 : 1;
    if (y >= z) return n.y > 0.0 ? 2 : 3;
    return n.z > 0.0 ? 4 : 5;
}

// Means over regions. Of the residuals one half has those of even places, the other of odd ones: which surfels were
// drawn is then no more common to both than the noise of rays.
class CoarseSystem {
public:
    CoarseSystem(const std::vector<Residual>& residuals, std::size_t regions, double rays)
        : residuals_(residuals), regions_(regions), rays_(rays), share_(regions, 0.0), from_(regions * regions) {
        for (const Residual& r : residuals_) {
            share_[r.region] += 1.0;
            for (const Gathered* half : r.halves)
                for (std::size_t g = 0; g < regions_; ++g) from_[r.region * regions_ + g] += half->from[g];
        }
        for (std::size_t k = 0; k < regions_; ++k) {
            for (std::size_t g = 0; g < regions_; ++g)
                if (share_[k] > 0.0) from_[k * regions_ + g] *= 1.0 / (2.0 * rays_ * share_[k]);
            share_[k] /= static_cast<double>(residuals_.size());
        }
        for (const std::size_t half : {0, 1}) {
            count_[half].assign(regions_, 0.0);
            mean_[half].resize(regions_);
            for (std::size_t k = half; k < residuals_.size(); k += 2) {
                count_[half][residuals_[k].region] += 1.0;
                mean_[half][residuals_[k].region] += residual(residuals_[k], half);
            }
            for (std::size_t g = 0; g < regions_; ++g)
                if (count_[half][g] > 0.0) mean_[half][g] *= 1.0 / count_[half][g];
        }
    }

    Rgb residual(const Residual& r, std::size_t half) const {
        return r.halves[half]->irradiance / rays_ - r.irradiance;
    }

    // Mean errors of all regions by one half.
    std::vector<Rgb> errors(std::size_t half) const {
        return solved(mean_[half], [&](std::size_t k, std::size_t g) { return from_[k * regions_ + g]; });
    }

    // By region, how often its mean residual counts in the mean error of all surfels: as often as what it brings goes
    // around (the adjoint system).
    std::vector<Rgb> weights_of_residuals() const {
        std::vector<Rgb> start(regions_);
        for (std::size_t k = 0; k < regions_; ++k) start[k] = Rgb{share_[k], share_[k], share_[k]};
        return solved(start, [&](std::size_t k, std::size_t g) { return from_[g * regions_ + k]; });
    }

    // The variance, of one half, of the mean error of all surfels, by those weights.
    Rgb variance_of_mean(std::size_t half, const std::vector<Rgb>& weight) const {
        Rgb variance;
        for (std::size_t k = half; k < residuals_.size(); k += 2) {
            const std::uint32_t g = residuals_[k].region;
            const Rgb off = (residual(residuals_[k], half) - mean_[half][g]) * weight[g] / count_[half][g];
            variance += off * off;
        }
        return variance;
    }

    // What errors of all regions bring to the place of a residual.
    Rgb brought(const std::vector<Rgb>& errors, const Residual& r) const {
        Rgb sum;
        for (const Gathered* half : r.halves)
            for (std::size_t g = 0; g < regions_; ++g) sum += half->from[g] * errors[g];
        return sum / (2.0 * rays_);
    }

private:
    // x = b + F x.
    template <class Entry>
    std::vector<Rgb> solved(const std::vector<Rgb>& b, const Entry& entry) const {
        const auto apply = [&](const std::vector<double>& x, std::vector<double>& out) {
            const std::vector<Rgb> all = unpacked(x);
            std::vector<Rgb> left = all;
            for (std::size_t k = 0; k < regions_; ++k)
                for (std::size_t g = 0; g < regions_; ++g) left[k] -= entry(k, g) * all[g];
            out = packed(left);
        };
        std::vector<double> x(3 * regions_, 0.0);
        gmres(apply, packed(b), LinearSystems(3), coarse_tolerance, most_applications, x);
        return unpacked(x);
    }

    static std::vector<double> packed(const std::vector<Rgb>& x) {
        std::vector<double> out;
        for (const Rgb& c : x) out.insert(out.end(), {c.x, c.y, c.z});
        return out;
    }
    static std::vector<Rgb> unpacked(const std::vector<double>& x) {
        std::vector<Rgb> out;
        for (std::size_t k = 0; k + 2 < x.size(); k += 3) out.push_back({x[k], x[k + 1], x[k + 2]});
        return out;
    }

    const std::vector<Residual>& residuals_;
    std::size_t regions_;
    double rays_;
    std::vector<double> share_;  // of the residuals, by region
    std::vector<Rgb> from_;      // by region that receives, and region that sends
    std::vector<double> count_[2];
    std::vector<Rgb> mean_[2];  // of the residuals of each half
};

}  // namespace

Regions::Regions(const Surfels& surfels, std::size_t wanted) : of(surfels.size()) {
    std::vector<std::uint32_t> order = morton_order(surfels.positions);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return main_direction(surfels.normals[a]) < main_direction(surfels.normals[b]);
    });
    double total = 0.0, area = 0.0;
    for (const double a : surfels.areas) total += a;
    int direction = -1;
    for (const std::uint32_t i : order) {
        const int own = main_direction(surfels.normals[i]);
        if (own != direction || area * static_cast<double>(wanted) >= total) ++count, area = 0.0, direction = own;
        area += surfels.areas[i];
        of[i] = static_cast<std::uint32_t>(count - 1);
    }
}

ErrorEstimate error_from(const std::vector<Residual>& residuals, std::size_t regions, double rays_each) {
    for (const Residual& r : residuals) {
        const Rgb both = r.irradiance + r.halves[0]->irradiance + r.halves[1]->irradiance;
        if (!std::isfinite(both.x + both.y + both.z)) return {1.0, 1.0};  // nothing is sure of it
    }
    const CoarseSystem system(residuals, regions, rays_each);
    const std::vector<Rgb> errors[2] = {system.errors(0), system.errors(1)};
    double off = 0.0, all = 0.0, spread = 0.0;
    for (const Residual& r : residuals) {
        const Rgb brought[2] = {system.brought(errors[0], r), system.brought(errors[1], r)};
        const Rgb e[2] = {system.residual(r, 0) + brought[0], system.residual(r, 1) + brought[1]};
        const double product = dot(e[0], e[1]);
        off += product;
        spread += product * product;
        all += dot(r.irradiance + e[0], r.irradiance + e[1]);
    }
    if (!(all > 0.0)) return spread == 0.0 ? ErrorEstimate{} : ErrorEstimate{1.0, 1.0};  // no light, or nothing sure
    // Products at single surfels are independent but for what is brought to all of them. Below the standard error of
    // their sum nothing is known: that is the least it claims.
    const std::vector<Rgb> weights = system.weights_of_residuals();
    const Rgb variance = 0.5 * (system.variance_of_mean(0, weights) + system.variance_of_mean(1, weights));
    const double common = (variance.x + variance.y + variance.z) * static_cast<double>(residuals.size());
    const double deviation = std::sqrt(spread + common * common);
    ErrorEstimate out;
    out.error = std::sqrt(std::max(off, deviation) / all);
    if (out.error > 0.0) out.uncertainty = deviation / (2.0 * out.error * all);
    return out;
}

}  // namespace surflux
