#include "surflux/lights/sky_irradiance.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr std::uint64_t sky_stream = 0x5c7a7;
// Standard error of the share of light that arrives, of n rays of which a share p is free: sqrt(p (1 - p)) n^-3/4 times
// this, measured.
constexpr double evenness = 1.0;
constexpr std::uint64_t refined_stream = 0x4ef1e;
constexpr double seen_well = 0.2;     // share of the sky's light that rays all over it tell well
constexpr int least_refined = 256;    // rays: fewer tell little of where the sky is seen
constexpr int most_of_part = 64;      // rays of a part of the sky around which some are free
constexpr double little = 0.02;       // of the light: noise beside it that does not matter
constexpr std::size_t region = 1024;  // places that lie together
constexpr double much_hidden = 5.0;   // times what arrives around
constexpr int least_behind = 512;     // rays behind openings

double squared(double x) { return x * x; }

// What arrives at one place of one tree of the sky.
class Arriving {
public:
    Arriving(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points, int rays, bool is_refined)
        : tracer_(tracer), sky_(sky), points_(points), most_rays_(rays), is_refined_(is_refined) {}

    // Of one more tree; `variance`: of what arrives.
    void add(std::size_t tree, const Place& place, std::uint64_t seed, SkyLight& to, double& variance) {
        const Rgb all = sky_.find_parts(tree, place.normal, parts_);
        if (parts_.empty()) return;
        EvenPoints even(points_.extends(place) ? 4 : 2, seed, stream_of(place));
        faced_ = arrived_ = {};
        taken_ = traced_ = free_count_ = 0;
        if (sky_.is_narrow(tree)) {  // most places see all of a spot or nothing
            shoot(std::max(2, most_rays_ / 8), tree, place, even);
            const bool all_agree = traced_ > 0 && (free_count_ == 0 || free_count_ == traced_);
            if (!all_agree) shoot(std::max(2, most_rays_ / 2), tree, place, even);
        } else {
            // All of them at once: stopping where the first ones agree would miss what hides little of the sky.
            shoot(most_rays_, tree, place, even);
        }
        const double share = traced_ > 0 ? static_cast<double>(free_count_) / traced_ : 1.0;
        Rgb found = all;
        if (is_refined_ && !sky_.is_narrow(tree) && taken_ >= least_refined && share < seen_well) {
            found = refined(tree, place, all, seed, variance);
        } else if (free_count_ < traced_) {
            variance += squared(luminance(all)) * variance_of_share(share, taken_);
            found = arriving(all, faced_, arrived_, share);
        }
        to.irradiance += found;
        if (sky_.is_narrow(tree)) return;
        to.arrived += luminance(found);
        to.hidden += luminance(all - found);
    }

private:
    struct Point {
        double u, v;  // of the square that the sky is mapped onto
        double weight;
    };

    // By other rays: one in each part of the square, about as many parts as there were rays, and as many again in those
    // around which some were free.
    Rgb refined(std::size_t tree, const Place& place, const Rgb& all, std::uint64_t seed, double& variance) {
        int side = 1;
        while (4 * side * side <= taken_) side *= 2;
        const auto part_of = [&](double u) { return std::min(side - 1, static_cast<int>(u * side)); };
        seen_.assign(static_cast<std::size_t>(side * side), 0);
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            if (!free_[r]) continue;
            const int row = part_of(at_[r].u), column = part_of(at_[r].v);
            for (int i = std::max(0, row - 1); i <= std::min(side - 1, row + 1); ++i)
                for (int j = std::max(0, column - 1); j <= std::min(side - 1, column + 1); ++j)
                    seen_[static_cast<std::size_t>(i * side + j)] = 1;
        }
        const auto seen = static_cast<int>(std::count(seen_.begin(), seen_.end(), 1));
        const int of_seen = std::clamp(taken_ / std::max(1, seen), 1, most_of_part);
        rays_.clear();
        light_.clear();
        at_.clear();
        Random random(seed + refined_stream, stream_of(place));
        std::vector<std::size_t> end;
        for (int part = 0; part < side * side; ++part) {
            const int count = seen_[static_cast<std::size_t>(part)] ? of_seen : 1;
            EvenPoints even(points_.extends(place) ? 4 : 2, random.bits(), 0);
            for (int k = 0; k < count; ++k) {
                const double* u = even.next();
                ask({(part / side + u[0]) / side, (part % side + u[1]) / side}, points_.at(place, u[2], u[3]));
            }
            aim(1.0 / count, tree, place);
            end.push_back(rays_.size());
        }
        trace();
        return of_parts(all, side * side - seen, of_seen, end, variance);
    }

    // Of rays of parts of the sky, those of part k ending at end[k]: one of each of some parts, `of_seen` of each
    // other.
    Rgb of_parts(const Rgb& all, int unseen, int of_seen, const std::vector<std::size_t>& end, double& variance) const {
        struct Light {
            Rgb faced, arrived;
        };
        Light sum, of_unseen;
        double squares = 0.0;
        const auto error_of = [&](const Light& of, int rays) {
            const double faced = luminance(of.faced);
            return faced > 0.0 ? squared(faced) * variance_of_share(luminance(of.arrived) / faced, rays) : 0.0;
        };
        std::size_t ray = 0;
        for (std::size_t part = 0; part < end.size(); ++part) {
            Light own;
            for (; ray < end[part]; ++ray) {
                const Rgb light = at_[ray].weight * light_[ray];
                own.faced += light;
                if (free_[ray]) own.arrived += light;
            }
            sum.faced += own.faced;
            sum.arrived += own.arrived;
            if (seen_[part]) {
                squares += error_of(own, of_seen);
            } else {
                of_unseen.faced += own.faced;
                of_unseen.arrived += own.arrived;
            }
        }
        if (unseen > 0) squares += error_of(of_unseen, unseen);
        const double faced = luminance(sum.faced), share = faced > 0.0 ? luminance(sum.arrived) / faced : 0.0;
        if (faced > 0.0) variance += squared(luminance(all) / faced) * squares;
        return arriving(all, sum.faced, sum.arrived, share);
    }

    // By what rays found, color by color; of a color that no ray had, `share`.
    static Rgb arriving(const Rgb& all, const Rgb& faced, const Rgb& arrived, double share) {
        Rgb out;
        for (int c = 0; c < 3; ++c) out[c] = all[c] * (faced[c] > 0.0 ? arrived[c] / faced[c] : share);
        return out;
    }

    static double variance_of_share(double share, int rays) {
        return squared(evenness) * std::max(0.0, share * (1.0 - share)) / std::pow(rays, 1.5);
    }

    void ask(const SkyCells::UnitPoint& at, const Vec3& from) {
        asked_.push_back(at);
        from_.push_back(from);
    }

    // Rays for all that was asked, which count `weight` each.
    void aim(double weight, std::size_t tree, const Place& place) {
        sky_.sample(tree, parts_, asked_, samples_);
        for (std::size_t k = 0; k < asked_.size(); ++k) {
            const SkyCells::Sample& sample = samples_[k];
            const double cosine = dot(place.normal, sample.direction);
            if (!(cosine > 0.0)) continue;
            rays_.push_back({{from_[k], place.normal, place.surfel}, sample.direction});
            at_.push_back({asked_[k].u, asked_[k].v, weight});
            light_.push_back((cosine / sample.mean_cosine) * sample.color);
        }
        asked_.clear();
        from_.clear();
    }

    void trace() {
        tracer_.free(rays_, free_);
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            const Rgb light = at_[r].weight * light_[r];
            faced_ += light;
            ++traced_;
            if (!free_[r]) continue;
            arrived_ += light;
            ++free_count_;
        }
    }

    // Up to `count` rays.
    void shoot(int count, std::size_t tree, const Place& place, EvenPoints& even) {
        rays_.clear();
        light_.clear();
        at_.clear();
        for (; taken_ < count; ++taken_) {
            const double* u = even.next();
            ask({u[0], u[1]}, points_.at(place, u[2], u[3]));
        }
        aim(1.0, tree, place);
        trace();
    }

    const Tracer& tracer_;
    const SkyCells& sky_;
    const SurfelPoints& points_;
    int most_rays_;
    bool is_refined_;
    int taken_ = 0, traced_ = 0, free_count_ = 0;
    Rgb faced_, arrived_;
    std::vector<SkyCells::Part> parts_;
    std::vector<Ray> rays_;
    std::vector<Rgb> light_;
    std::vector<Point> at_;
    std::vector<SkyCells::UnitPoint> asked_;
    std::vector<Vec3> from_;
    std::vector<SkyCells::Sample> samples_;
    std::vector<char> free_, seen_;
};

std::vector<SkyLight> light_of(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                               const std::vector<Place>& places, int rays, bool is_refined, std::uint64_t seed,
                               const Progress& progress) {
    std::vector<SkyLight> out(places.size());
    if (sky.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Arriving arriving(tracer, sky, points, rays, is_refined);
            for (std::size_t k = begin; k < end; ++k) {
                double variance = 0.0;
                for (std::size_t tree = 0; tree < sky.trees(); ++tree)
                    arriving.add(tree, places[k], seed + sky_stream + tree, out[k], variance);
                out[k].error = std::sqrt(variance);
            }
        },
        progress);
    return out;
}

std::vector<std::size_t> places_behind_openings(const std::vector<Place>& places, int rays,
                                                const std::vector<double>& others, const std::vector<SkyLight>& found,
                                                const Progress& progress) {
    std::vector<std::size_t> out;
    std::vector<Vec3> positions;
    for (const Place& place : places) positions.push_back(place.position);
    const std::vector<std::uint32_t> order = morton_order(positions, progress);
    const double noise = evenness / std::pow(rays, 0.75);
    for (std::size_t begin = 0; begin < order.size(); begin += region) {
        const std::size_t end = std::min(order.size(), begin + region);
        double squares = 0.0;
        for (std::size_t i = begin; i < end; ++i) squares += squared(found[order[i]].arrived);
        const double level = std::sqrt(squares / static_cast<double>(end - begin));
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t k = order[i];
            const double hidden = found[k].hidden;
            const bool is_noisy = noise * std::sqrt(level * hidden) > little * others[k];
            if (level > 0.0 && hidden > much_hidden * level && is_noisy) out.push_back(k);
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

}  // namespace

std::vector<SkyLight> sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                     const std::vector<Place>& places, int rays, std::uint64_t seed,
                                     const Progress& progress) {
    return light_of(tracer, sky, points, places, rays, false, seed, progress);
}

std::vector<SkyLight> refined_sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                             const std::vector<Place>& places, int rays, std::uint64_t seed,
                                             const Progress& progress) {
    return light_of(tracer, sky, points, places, rays, true, seed, progress);
}

void refine_behind_openings(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                            const std::vector<Place>& places, int rays, const std::vector<double>& others,
                            std::uint64_t seed, const Progress& progress, const Team& team,
                            std::vector<SkyLight>& found) {
    const std::vector<std::size_t> few = places_behind_openings(places, rays, others, found, progress);
    std::vector<Place> again;
    for (const std::size_t k : few) again.push_back(places[k]);
    if (few.empty()) return;
    const auto refined = shared_values<SkyLight>(team, "direct light", seed, again, [&](const std::vector<Place>& at) {
        return refined_sky_irradiance(tracer, sky, points, at, std::max(least_behind, rays), seed, progress);
    });
    for (std::size_t j = 0; j < few.size(); ++j) found[few[j]] = refined[j];
}

}  // namespace surflux
