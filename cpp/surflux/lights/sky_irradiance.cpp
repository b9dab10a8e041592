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

// What arrives at one place of one tree of the sky.
class Arriving {
public:
    Arriving(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points, int rays)
        : tracer_(tracer), sky_(sky), points_(points), most_rays_(rays) {}

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
        if (free_count_ == 0) return {};
        if (free_count_ == traced_) return all;
        const double share = static_cast<double>(free_count_) / traced_;
        const double error = luminance(all) * evenness * std::sqrt(share * (1.0 - share)) / std::pow(taken_, 0.75);
        variance += error * error;
        for (int c = 0; c < 3; ++c) all[c] *= faced_[c] > 0.0 ? arrived_[c] / faced_[c] : share;
        return all;
    }

private:
    // Up to `count` rays.
    void shoot(int count, std::size_t tree, const Place& place, EvenPoints& even) {
        rays_.clear();
        light_.clear();
        for (; taken_ < count; ++taken_) {
            const double* u = even.next();
            Vec3 direction;
            const SkyCells::Part& cell = sky_.sample(tree, parts_, u[0], u[1], direction);
            const double cosine = dot(place.normal, direction);
            if (!(cosine > 0.0)) continue;
            rays_.push_back({{points_.at(place, u[2], u[3]), place.normal, place.surfel}, direction});
            const double scale = cosine / (static_cast<double>(cell.cosine) * static_cast<double>(cell.weight));
            light_.push_back({scale * static_cast<double>(cell.irradiance[0]),
                              scale * static_cast<double>(cell.irradiance[1]),
                              scale * static_cast<double>(cell.irradiance[2])});
        }
        tracer_.free(rays_, free_);
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            faced_ += light_[r];
            ++traced_;
            if (!free_[r]) continue;
            arrived_ += light_[r];
            ++free_count_;
        }
    }

    const Tracer& tracer_;
    const SkyCells& sky_;
    const SurfelPoints& points_;
    int most_rays_;
    int taken_ = 0, traced_ = 0, free_count_ = 0;
    Rgb faced_, arrived_;
    std::vector<SkyCells::Part> parts_;
    std::vector<Ray> rays_;
    std::vector<Rgb> light_;
    std::vector<char> free_;
};

}  // namespace

std::vector<Rgb> sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                const std::vector<Place>& places, int rays, std::uint64_t seed,
                                const Progress& progress, std::vector<float>* errors) {
    std::vector<Rgb> out(places.size());
    if (errors) errors->assign(places.size(), 0.0f);
    if (sky.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Arriving arriving(tracer, sky, points, rays);
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

}  // namespace surflux
