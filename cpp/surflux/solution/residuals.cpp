#include "surflux/solution/residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "surflux/solution/gmres.h"

namespace surflux {

namespace {

constexpr double coarse_tolerance = 1e-9;
constexpr int most_applications = 1000;
constexpr int scaling_rounds = 100;

// Weighted sums of two quantities over places, and of their squares and products.
struct Moments {
    double places = 0.0, count = 0.0;  // and the sum of their weights
    Rgb x, y, xy, yy;
    void add(const Rgb& of_x, const Rgb& of_y, double w = 1.0) {
        places += 1.0, count += w, x += w * of_x, y += w * of_y, xy += w * of_x * of_y, yy += w * of_y * of_y;
    }
    void operator+=(const Moments& m) {
        places += m.places, count += m.count, x += m.x, y += m.y, xy += m.xy, yy += m.yy;
    }
    // About the means.
    Rgb products() const { return count > 0.0 ? xy - x * y / count : Rgb{}; }
    Rgb squares() const { return count > 0.0 ? yy - y * y / count : Rgb{}; }
};

// Means over regions. Of the residuals one half has those of even places, the other of odd ones: which surfels were
// drawn is then no more common to both than the variance of rays is.
class CoarseSystem {
public:
    CoarseSystem(const std::vector<Residual>& residuals, const Regions& regions, double rays, const Rgb& balance)
        : residuals_(residuals), regions_(regions.count), rays_(rays), share_(regions.share), slope_(regions_) {
        exchange(regions);
        std::vector<Moments> both(regions_);
        for (const std::size_t half : {0, 1}) {
            of_[half].resize(regions_);
            for (std::size_t k = half; k < residuals_.size(); k += 2)
                of_[half][residuals_[k].region].add(one_bounce(residuals_[k], half), control(residuals_[k], half),
                                                    residuals_[k].weight);
            for (std::size_t g = 0; g < regions_; ++g) both[g] += of_[half][g];
        }
        Rgb variance;
        for (std::size_t g = 0; g < regions_; ++g)
            if (both[g].count > 0.0) variance += std::pow(share_[g] / both[g].count, 2) * both[g].squares();
        for (std::size_t g = 0; g < regions_; ++g)
            for (int c = 0; c < 3; ++c)
                if (both[g].count > 0.0 && variance[c] > 0.0)
                    slope_[g][c] = share_[g] * both[g].products()[c] / (both[g].count * both[g].count * variance[c]);
        for (const std::size_t half : {0, 1}) regress(half, balance);
    }

    Rgb residual(const Residual& r, std::size_t half) const {
        return (r.halves[half]->irradiance + r.halves[half]->lamps.sum()) / rays_ - r.irradiance;
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

    // The variance, of one half, of the mean error of all surfels, by those weights. That within a region is taken from
    // the places of both halves; where there is but one, from all regions.
    Rgb variance_of_mean(std::size_t half, const std::vector<Rgb>& weight) const {
        Rgb of_control;
        for (std::size_t g = 0; g < regions_; ++g) of_control += weight[g] * slope_[g];
        std::vector<Moments> terms(regions_);
        for (std::size_t k = 0; k < residuals_.size(); ++k) {
            const std::uint32_t g = residuals_[k].region;
            const double count = of_[half][g].count;
            if (count == 0.0) continue;
            const Rgb term =
                weight[g] * one_bounce(residuals_[k], k % 2) - share_[g] * of_control * control(residuals_[k], k % 2);
            const double part = residuals_[k].weight / count;
            terms[g].add(part * term, part * term);
        }
        Rgb variance, squares;
        double free = 0.0, single = 0.0;
        for (std::size_t g = 0; g < regions_; ++g) {
            if (terms[g].count < 2.0) {
                single += terms[g].count;
                continue;
            }
            squares += terms[g].squares();
            free += terms[g].count - 1.0;
            variance += (of_[half][g].places / (terms[g].count - 1.0)) * terms[g].squares();
        }
        return free > 0.0 ? variance + (single / free) * squares : variance;
    }

    // What errors of all regions bring to the place of a residual, by the rays of one half: they have the variance of
    // those of the residual.
    Rgb brought(const std::vector<Rgb>& errors, const Residual& r, std::size_t half) const {
        Rgb sum;
        for (std::size_t g = 0; g < regions_; ++g) sum += r.halves[half]->from[g] * errors[g];
        return sum / rays_;
    }

private:
    // Of one bounce, and c of error_from().
    Rgb one_bounce(const Residual& r, std::size_t half) const {
        return (r.halves[half]->of_all + r.halves[half]->lamps.sum()) / rays_ - r.irradiance;
    }
    Rgb control(const Residual& r, std::size_t half) const {
        const Gathered& h = *r.halves[half];
        return r.direct + (h.of_surfels + h.lost * r.radiosity) / rays_ - r.irradiance;
    }

    // F, of symmetric exchanges scaled as by Sinkhorn and Knopp (1967), with losses as one more column.
    void exchange(const Regions& regions) {
        std::vector<double> count(regions_), lost(regions_), seen(regions_ * regions_), both(regions_ * regions_);
        // Of light, per unit of the mean error: what leaves a region, of that what is lost, and by region where it
        // ends.
        std::vector<Rgb> left(regions_), left_lost(regions_), carried(regions_ * regions_);
        for (const Residual& r : residuals_) {
            const Rgb light = r.weight * r.reflectance * regions.shape(r.region, r.irradiance);
            count[r.region] += r.weight * 2.0 * rays_;
            left[r.region] += (2.0 * rays_) * light;
            for (const Gathered* half : r.halves) {
                lost[r.region] += r.weight * half->lost;
                left_lost[r.region] += half->lost * light;
                for (std::size_t g = 0; g < regions_; ++g) {
                    seen[r.region * regions_ + g] += r.weight * half->met[g];
                    carried[r.region * regions_ + g] += half->met[g] * light;
                }
            }
        }
        for (std::size_t k = 0; k < regions_; ++k) {
            if (count[k] == 0.0) continue;
            lost[k] *= share_[k] / count[k];
            for (std::size_t g = 0; g < regions_; ++g) {
                // By as many rays as each region has; what has none knows nothing.
                const double exchanged = seen[k * regions_ + g] * share_[k] / (count[g] > 0.0 ? 2.0 : 1.0) / count[k];
                both[k * regions_ + g] += exchanged, both[g * regions_ + k] += exchanged;
            }
        }
        std::vector<double> scale(regions_, 1.0), row(regions_);
        for (int round = 0; round < scaling_rounds; ++round) {
            for (std::size_t k = 0; k < regions_; ++k) {
                row[k] = lost[k];
                for (std::size_t g = 0; g < regions_; ++g) row[k] += both[k * regions_ + g] * scale[g];
            }
            for (std::size_t k = 0; k < regions_; ++k)
                if (row[k] > 0.0 && count[k] > 0.0) scale[k] = std::sqrt(scale[k] * share_[k] / row[k]);
        }
        from_.resize(regions_ * regions_);
        for (std::size_t g = 0; g < regions_; ++g) {
            Rgb sum;
            for (std::size_t k = 0; k < regions_; ++k) {
                const double exchanged = scale[k] * scale[g] * both[k * regions_ + g], met = seen[g * regions_ + k];
                from_[k * regions_ + g] =
                    exchanged * (met > 0.0 ? carried[g * regions_ + k] / met : regions.reflectance[g]);
                sum += from_[k * regions_ + g];
            }
            for (int c = 0; c < 3; ++c) {
                const double rest = left[g][c] > 0.0 ? share_[g] * (1.0 - left_lost[g][c] / left[g][c]) : 0.0;
                const double all = sum[c] > 0.0 && rest > 0.0 ? rest / sum[c] * regions.reflectance[g][c] : 1.0;
                for (std::size_t k = 0; k < regions_; ++k)
                    from_[k * regions_ + g][c] *= share_[k] > 0.0 ? all / share_[k] : 0.0;
            }
        }
    }

    // Of regions without a place in this half nothing is known: the control variate is theirs as of all others.
    void regress(std::size_t half, const Rgb& balance) {
        Rgb control;
        double known = 0.0;
        for (std::size_t g = 0; g < regions_; ++g) {
            const Moments& m = of_[half][g];
            mean_[half].push_back(m.count > 0.0 ? m.x / m.count : Rgb{});
            if (m.count > 0.0) control += share_[g] * m.y / m.count, known += share_[g];
        }
        if (!(known > 0.0)) return;
        for (std::size_t g = 0; g < regions_; ++g)
            if (of_[half][g].count > 0.0) mean_[half][g] += slope_[g] * (balance - control / known);
    }

    // x = b + F x.
    template <class Entry>
    std::vector<Rgb> solved(const std::vector<Rgb>& b, const Entry& entry) const {
        const auto apply = [&](const std::vector<double>& x, std::vector<double>& out) {
            const std::vector<Rgb> all = unpacked(x);
            std::vector<Rgb> product = all;
            for (std::size_t k = 0; k < regions_; ++k)
                for (std::size_t g = 0; g < regions_; ++g) product[k] -= entry(k, g) * all[g];
            out = packed(product);
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
    std::vector<double> share_;   // of all area
    std::vector<Rgb> from_;       // by region that receives, and region that sends
    std::vector<Moments> of_[2];  // of residuals and control variates of each half, by region
    std::vector<Rgb> mean_[2];    // of the residuals of each half
    std::vector<Rgb> slope_;      // of those means in the mean of the control variate
};

// The same sums as over all, of one region.
struct LocalError {
    double count = 0.0, off = 0.0, all = 0.0, squares = 0.0;
    void add(double product, double squared, double w) {
        count += w, off += w * product, all += w * squared, squares += w * product * w * product;
    }
    double deviation() const { return std::sqrt(squares); }
};

// Of values that count for so many; 0 of none.
double quantile(std::vector<std::pair<double, double>> values, double share) {
    std::sort(values.begin(), values.end());
    double total = 0.0, up_to = 0.0;
    for (const auto& [value, count] : values) total += count;
    for (const auto& [value, count] : values)
        if ((up_to += count) >= share * total) return value;
    return 0.0;
}

}  // namespace

void Gathered::pack(Packed& to) const {
    std::uint32_t count = 0;
    const auto is_met = [&](std::size_t k) { return met[k] > 0.0 || !(from[k] == Rgb{}); };
    for (std::size_t k = 0; k < met.size(); ++k) count += is_met(k);
    to.add(count);
    for (std::size_t k = 0; k < met.size(); ++k)
        if (is_met(k)) to.add(static_cast<std::uint32_t>(k)), to.add(met[k]), to.add(from[k]);
    to.add(lamps), to.add(irradiance), to.add(lost), to.add(of_surfels), to.add(of_all);
}

void Gathered::unpack(Unpacking& bytes) {
    std::fill(met.begin(), met.end(), 0.0);
    std::fill(from.begin(), from.end(), Rgb{});
    for (auto count = bytes.take<std::uint32_t>(); count > 0; --count) {
        const auto k = bytes.take<std::uint32_t>();
        if (k >= met.size()) throw DeviceError("another process sent a region that there is not");
        bytes.take(&met[k], 1), bytes.take(&from[k], 1);
    }
    bytes.take(&lamps, 1), bytes.take(&irradiance, 1), bytes.take(&lost, 1);
    bytes.take(&of_surfels, 1), bytes.take(&of_all, 1);
}

Rgb Gathered::Lamps::sum() const {
    Rgb out = by_themselves;
    for (int c = 0; c < 3; ++c)
        if (all[c] > 0.0) out[c] += lit[c] / all[c] * unoccluded[c];
    return out;
}

ErrorEstimate error_from(const std::vector<Residual>& residuals, const Regions& regions, double rays_each,
                         const Rgb& balance, double dimmest) {
    const ErrorEstimate unsure{1.0, 1.0, 1.0, 1.0, 0.0};
    if (!std::isfinite(balance.x + balance.y + balance.z)) return unsure;  // some surfel, perhaps not drawn
    for (const Residual& r : residuals) {
        const Rgb both = r.irradiance + r.direct + r.radiosity + r.halves[0]->irradiance + r.halves[1]->irradiance +
                         r.halves[0]->lamps.sum() + r.halves[1]->lamps.sum();
        if (!std::isfinite(both.x + both.y + both.z)) return unsure;  // nothing is sure of it
    }
    const CoarseSystem system(residuals, regions, rays_each, balance);
    const std::vector<Rgb> errors[2] = {system.errors(0), system.errors(1)};
    double off = 0.0, all = 0.0, spread = 0.0, count = 0.0;
    std::vector<LocalError> local(regions.count);
    for (const Residual& r : residuals) {
        const Rgb brought[2] = {system.brought(errors[0], r, 0), system.brought(errors[1], r, 1)};
        const Rgb e[2] = {system.residual(r, 0) + brought[0], system.residual(r, 1) + brought[1]};
        const double product = dot(e[0], e[1]);
        off += r.weight * product;
        spread += r.weight * product * r.weight * product;
        count += r.weight;
        const double squared = dot(r.irradiance + e[0], r.irradiance + e[1]);
        all += r.weight * squared;
        local[regions.whole[r.region]].add(product, squared, r.weight);
    }
    if (!(all > 0.0)) {
        // Nothing arrives and no ray finds that anything should: 0 of 0, which is no precision to boast of.
        constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
        return spread == 0.0 ? ErrorEstimate{unknown, unknown, unknown, unknown, 0.0} : unsure;
    }
    // Products at single surfels are independent but for what is brought to all of them. Below the standard error of
    // their sum nothing is known: that is the least it claims.
    const std::vector<Rgb> weights = system.weights_of_residuals();
    const Rgb variance = 0.5 * (system.variance_of_mean(0, weights) + system.variance_of_mean(1, weights));
    const double common = (variance.x + variance.y + variance.z) * count;
    const double deviation = std::sqrt(spread + common * common);
    ErrorEstimate out;
    out.error = std::sqrt(std::max(off, deviation) / all);
    if (out.error > 0.0) out.uncertainty = deviation / (2.0 * out.error * all);
    const double least = dimmest * dimmest * all / count;
    std::vector<std::pair<double, double>> errors_by_region, floors;  // and how many surfels each stands for
    for (const LocalError& region : local) {
        if (!(region.count > 0.0) || !(region.all > least * region.count)) continue;
        errors_by_region.emplace_back(std::sqrt(std::max(region.off, region.deviation()) / region.all), region.count);
        floors.emplace_back(std::sqrt(region.deviation() / region.all), region.count);
    }
    out.local = quantile(errors_by_region, 0.5);
    out.local_p90 = quantile(std::move(errors_by_region), 0.9);
    out.local_floor = quantile(std::move(floors), 0.9);
    return out;
}

}  // namespace surflux
