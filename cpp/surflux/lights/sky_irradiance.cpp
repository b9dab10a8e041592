#include "surflux/lights/sky_irradiance.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr std::uint64_t sky_stream = 0x5c7a7;
// Standard error of the share of light that arrives, of n rays of which a share p is free: sqrt(p (1 - p)) n^-3/4 times
// this, measured.
constexpr double evenness = 1.0;
constexpr std::uint64_t refined_stream = 0x4ef1e;
constexpr double seen_well = 0.2;   // share of the sky's light that rays all over it tell well
constexpr int least_refined = 256;  // rays: fewer tell little of where the sky is seen
constexpr int most_of_part = 64;    // rays of a part of the sky around which some are free

// What arrives at one place of one tree of the sky.
class Arriving {
public:
    Arriving(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points, int rays, bool is_refined)
        : tracer_(tracer), sky_(sky), points_(points), most_rays_(rays), is_refined_(is_refined) {}

    Rgb irradiance(std::size_t tree, const Place& place, std::uint64_t seed, double& variance) {
        Rgb all = sky_.find_parts(tree, place.normal, parts_);
        if (parts_.empty()) return {};
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
        if (is_refined_ && !sky_.is_narrow(tree) && taken_ >= least_refined && share < seen_well)
            return refined(tree, place, all, seed);
        if (free_count_ == 0) return {};
        if (free_count_ == traced_) return all;
        const double error = luminance(all) * evenness * std::sqrt(share * (1.0 - share)) / std::pow(taken_, 0.75);
        variance += error * error;
        for (int c = 0; c < 3; ++c) all[c] *= faced_[c] > 0.0 ? arrived_[c] / faced_[c] : share;
        return all;
    }

private:
    struct Point {
        double u, v;  // of the square that the sky is mapped onto
        double weight;
    };

    // By other rays: one in each part of the square, about as many parts as there were rays, and as many again in those
    // around which some were free.
    Rgb refined(std::size_t tree, const Place& place, const Rgb& all, std::uint64_t seed) {
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
        faced_ = arrived_ = {};
        rays_.clear();
        light_.clear();
        at_.clear();
        Random random(seed + refined_stream, stream_of(place));
        for (int part = 0; part < side * side; ++part) {
            const int count = seen_[static_cast<std::size_t>(part)] ? of_seen : 1;
            EvenPoints even(2, random.bits(), 0);
            for (int k = 0; k < count; ++k) {
                const double* u = even.next();
                add({(part / side + u[0]) / side, (part % side + u[1]) / side, 1.0 / count}, tree, place,
                    place.position);
            }
        }
        trace();
        Rgb out;
        for (int c = 0; c < 3; ++c) out[c] = faced_[c] > 0.0 ? all[c] * arrived_[c] / faced_[c] : 0.0;
        return out;
    }

    void add(const Point& at, std::size_t tree, const Place& place, const Vec3& from) {
        Vec3 direction;
        const SkyCells::Part& cell = sky_.sample(tree, parts_, at.u, at.v, direction);
        const double cosine = dot(place.normal, direction);
        if (!(cosine > 0.0)) return;
        rays_.push_back({{from, place.normal, place.surfel}, direction});
        at_.push_back(at);
        const double scale = cosine / (static_cast<double>(cell.cosine) * static_cast<double>(cell.weight));
        light_.push_back({scale * static_cast<double>(cell.irradiance[0]),
                          scale * static_cast<double>(cell.irradiance[1]),
                          scale * static_cast<double>(cell.irradiance[2])});
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
            add({u[0], u[1], 1.0}, tree, place, points_.at(place, u[2], u[3]));
        }
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
    std::vector<char> free_, seen_;
};

std::vector<Rgb> irradiance_of(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                               const std::vector<Place>& places, int rays, bool is_refined, std::uint64_t seed,
                               const Progress& progress, std::vector<float>* errors) {
    std::vector<Rgb> out(places.size());
    if (errors) errors->assign(places.size(), 0.0f);
    if (sky.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Arriving arriving(tracer, sky, points, rays, is_refined);
            for (std::size_t k = begin; k < end; ++k) {
                double variance = 0.0;
                for (std::size_t tree = 0; tree < sky.trees(); ++tree)
                    out[k] += arriving.irradiance(tree, places[k], seed + sky_stream + tree, variance);
                if (errors) (*errors)[k] = static_cast<float>(std::sqrt(variance));
            }
        },
        progress);
    return out;
}

}  // namespace

std::vector<Rgb> sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                const std::vector<Place>& places, int rays, std::uint64_t seed,
                                const Progress& progress, std::vector<float>* errors) {
    return irradiance_of(tracer, sky, points, places, rays, false, seed, progress, errors);
}

std::vector<Rgb> refined_sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                        const std::vector<Place>& places, int rays, std::uint64_t seed,
                                        const Progress& progress) {
    return irradiance_of(tracer, sky, points, places, rays, true, seed, progress, nullptr);
}

}  // namespace surflux
