#include "surflux/solution/self_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr std::size_t least_checked = 400, most_checked = 1000, surfels_per_check = 10;
constexpr std::uint64_t pick_stream = 0x5e1fc8ec, gather_stream = 0x6a7e85ed, second_stream = 0x5ec0bd11;

// Light that rays bring, with the solution at the end of the second bounce.
class SecondGather {
public:
    struct Sources {
        explicit Sources(const Scene& scene)
            : points(scene.surfels),
              emitters(scene, LightSampler::usual_small_emitters, LightSampler::Sources::surfels),
              lights(scene) {}
        SurfelPoints points;
        LightSampler emitters, lights;
    };
    SecondGather(const Scene& scene, const Tracer& tracer, const std::vector<Rgb>& irradiance, const Sources& sources)
        : surfels_(scene.surfels),
          tracer_(tracer),
          irradiance_(irradiance),
          points_(sources.points),
          emitters_(sources.emitters),
          lights_(sources.lights) {}

    // What comes to surfel i from surfels; the mean of `count` rays.
    Rgb operator()(std::uint32_t i, int count, std::uint64_t seed, std::uint64_t stream) {
        const Frame frame = frame_around(surfels_.normals[i]);
        EvenPoints even(4, seed + gather_stream, stream);
        Random random(seed + second_stream, stream);
        sum_ = {};
        met_.clear();
        for (int r = 0; r < count; ++r) {
            const double* u = even.next();
            const Vec3 from = points_.at(i, u[2], u[3]);
            const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
            const Hit hit = tracer_.closest(i, from, direction);
            sum_ += emitters_.found(from, frame.n, direction, hit);
            if (!emitters_.empty()) {
                const double a = random.uniform(), b = random.uniform();
                aim(emitters_.sample(from, frame.n, a, b, 0.0), {1, 1, 1}, {from, frame.n, i});
            }
            if (!hit || !hit.front || surfels_.reflectance[hit.surfel] == Rgb{}) continue;
            met_.push_back({from + hit.distance * direction, surfels_.normals[hit.surfel], hit.surfel});
        }
        for (const Departure& at : met_) gather_again(at, random);
        trace();
        return sum_ / count;
    }

    std::size_t rays = 0;

private:
    struct Gain {
        Rgb irradiance;
        std::uint32_t target;
    };

    void aim(const LightRay& light, const Rgb& throughput, const Departure& from) {
        if (!(light.length > 0.0)) return;
        const bool free = light.target == Hit::none;
        (free ? shadow_ : towards_).push_back({from, light.direction, light.length});
        (free ? shadow_gain_ : towards_gain_).push_back({throughput * light.irradiance, light.target});
    }

    void gather_again(const Departure& at, Random& random) {
        double u[5];
        for (double& x : u) x = random.uniform();
        if (!lights_.empty())
            aim(lights_.sample(at.position, at.normal, u[0], u[1], u[2]), surfels_.reflectance[at.surfel], at);
        ahead_.push_back({at, frame_around(at.normal).to_world(square_to_cosine_hemisphere(u[3], u[4]))});
    }

    // All rays that wait, at once.
    void trace() {
        rays += met_.size() + shadow_.size() + towards_.size() + ahead_.size();
        tracer_.free(shadow_, free_);
        for (std::size_t k = 0; k < shadow_.size(); ++k)
            if (free_[k]) sum_ += shadow_gain_[k].irradiance;
        tracer_.closest(towards_, hits_);
        for (std::size_t k = 0; k < towards_.size(); ++k)
            if (hits_[k].front && hits_[k].surfel == towards_gain_[k].target) sum_ += towards_gain_[k].irradiance;
        tracer_.closest(ahead_, hits_);
        for (std::size_t k = 0; k < ahead_.size(); ++k) {
            const Ray& ray = ahead_[k];
            Rgb found = lights_.found(ray.from.position, ray.from.normal, ray.direction, hits_[k]);
            if (hits_[k] && hits_[k].front) {
                const std::uint32_t j = hits_[k].surfel;
                found += surfels_.reflectance[j] * irradiance_[j];
            }
            sum_ += surfels_.reflectance[ray.from.surfel] * found;
        }
        shadow_.clear(), shadow_gain_.clear(), towards_.clear(), towards_gain_.clear(), ahead_.clear();
    }

    const Surfels& surfels_;
    const Tracer& tracer_;
    const std::vector<Rgb>& irradiance_;
    const SurfelPoints& points_;
    const LightSampler &emitters_, &lights_;
    Rgb sum_;
    std::vector<Departure> met_;
    std::vector<Ray> shadow_, towards_, ahead_;
    std::vector<Gain> shadow_gain_, towards_gain_;
    std::vector<char> free_;
    std::vector<Hit> hits_;
};

// What a solution says of the scene's own surfels: means over those inserted below each, by area.
struct OwnSurfels {
    std::vector<Rgb> irradiance, direct;
    OwnSurfels(const Surfels& s, const Solution& solution) : irradiance(s.size()), direct(s.size()) {
        std::vector<double> areas(s.size(), 0.0);
        for (std::size_t k = 0; k < solution.parents.size(); ++k) {
            const std::uint32_t i = solution.parents[k];
            const double area = solution.surfels.areas[k];
            areas[i] += area;
            irradiance[i] += area * solution.irradiance[k];
            direct[i] += area * solution.direct[k];
        }
        for (std::size_t i = 0; i < s.size(); ++i) irradiance[i] *= 1.0 / areas[i], direct[i] *= 1.0 / areas[i];
    }
};

// Surfels in proportion to their area, evenly along the list; large ones may come more than once.
std::vector<std::uint32_t> drawn_by_area(const Surfels& s, std::size_t count, std::uint64_t seed) {
    std::vector<std::uint32_t> out;
    double total = 0.0, up_to = 0.0;
    for (double area : s.areas) total += area;
    Random random(seed + pick_stream, 0);
    const double step = total / static_cast<double>(count);
    double next = step * random.uniform();
    for (std::uint32_t i = 0; i < s.size(); ++i)
        for (up_to += s.areas[i]; next < up_to && out.size() < count; next += step) out.push_back(i);
    return out;
}

}  // namespace

SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                          std::uint64_t seed, const Progress& progress) {
    const Surfels& s = scene.surfels;
    const OwnSurfels own(s, solution);
    const std::vector<std::uint32_t> drawn = drawn_by_area(s, static_cast<std::size_t>(surfels), seed);
    const std::size_t checked = drawn.size();
    std::vector<double> squared(checked), reference(checked);
    const SecondGather::Sources sources(scene);
    std::atomic<std::size_t> traced{0};
    parallel_blocks(
        checked, 8,
        [&](std::size_t begin, std::size_t end) {
            SecondGather gather(scene, tracer, own.irradiance, sources);
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = drawn[k];
                const Rgb off = own.direct[i] - own.irradiance[i];
                squared[k] = dot(off + gather(i, rays, seed, 2 * k), off + gather(i, rays, seed, 2 * k + 1));
                reference[k] = dot(own.irradiance[i], own.irradiance[i]);
            }
            traced += gather.rays + 2 * (end - begin) * static_cast<std::size_t>(rays);
        },
        progress);
    double off = 0.0, all = 0.0, spread = 0.0;
    for (std::size_t k = 0; k < checked; ++k) off += squared[k], all += reference[k], spread += squared[k] * squared[k];
    // Below the standard error of the sum nothing is known: that is the least it claims.
    return {all > 0.0 ? std::sqrt(std::max(off, std::sqrt(spread)) / all) : 0.0, traced};
}

int usual_checks(std::size_t surfels) {
    return static_cast<int>(std::clamp(surfels / surfels_per_check, least_checked, most_checked));
}

void check_solution(const Scene& scene, const Tracer& tracer, int surfels, int rays, std::uint64_t seed,
                    const Progress& progress, Solution& solution) {
    Stopwatch watch(solution.timings);
    const SelfCheck check = gathering_error(scene, tracer, solution, surfels, rays, seed, progress);
    watch.lap("self-check");
    solution.error = check.error;
    Figures& figures = solution.history.back();
    figure(figures, "rays") += static_cast<double>(check.rays);
    figure(figures, "error") = check.error;
    figure(figures, "seconds") = total_seconds(solution.timings);
}

}  // namespace surflux
