#include "surflux/reference/reference.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t least_batches = 16;
constexpr std::size_t paths_at_once = 1024;  // one step of all of them fits in the cache
// Roulette begins where a path can bring less than this share of what it meets. Measured on four scenes at 4096
// samples: 1/16 takes 2.3 to 60 times fewer seconds to the same error than roulette from the second bounce on.
constexpr double certain_throughput = 1.0 / 16.0;
// Far apart, so that runs with seeds next to each other share nothing.
constexpr std::uint64_t direction_stream = 0x7ef0000000000000, choice_stream = 0x3c51000000000000;

struct Path {
    Departure at;
    Rgb throughput{1, 1, 1};
    Random random;
    std::uint32_t batch;
};

// The square of a difference, channel by channel.
Rgb squared(const Rgb& a) { return a * a; }

// Count, mean and sum of squared deviations of batches (Chan, Golub and LeVeque 1983).
struct Moments {
    double count = 0.0;
    Rgb mean, spread;
    void add(const Moments& other) {
        if (other.count == 0.0) return;
        const double total = count + other.count;
        const Rgb off = other.mean - mean;
        mean += (other.count / total) * off;
        spread += other.spread + (count * other.count / total) * squared(off);
        count = total;
    }
};

// How the samples of a point are split.
struct Plan {
    explicit Plan(std::size_t samples) {
        while (4 * per_batch * per_batch <= samples && 2 * per_batch * least_batches <= samples) per_batch *= 2;
        batches = std::max(least_batches, (samples + per_batch - 1) / per_batch);
        per_chunk = std::max<std::size_t>(1, paths_at_once / per_batch);
        chunks = (batches + per_chunk - 1) / per_chunk;
    }
    std::size_t per_batch = 1, batches, per_chunk, chunks;
};

class PathTracer {
public:
    PathTracer(const CompiledScene& compiled, const ReferenceOptions& options, const Progress& progress)
        : surfels_(compiled.scene().surfels),
          tracer_(compiled.tracer(progress)),
          lights_(compiled.scene(), options.small_emitters),
          seed_(options.seed) {}

    void require_near(const std::vector<Vec3>& points) const { tracer_.require_near(points); }

    // Sums of batches [first, last) of the point, each of per_batch paths; returns the number of rays.
    std::size_t trace(const Vec3& point, const Vec3& normal, std::uint64_t stream, const Plan& plan, std::size_t first,
                      std::size_t last, std::vector<Rgb>& sums) const;

private:
    // Rays of one step of all paths, and what each brings if it is free, or meets what it wants.
    struct Step {
        struct Gain {
            std::uint32_t path;
            Rgb irradiance;
            std::uint32_t target;
        };
        std::vector<Ray> shadow, ahead;
        std::vector<Gain> shadow_gain, ahead_gain;
        std::vector<char> free;
        std::vector<Hit> hits;
        void clear() { shadow.clear(), ahead.clear(), shadow_gain.clear(), ahead_gain.clear(); }
    };
    void aim(const Path& path, std::uint32_t index, const double* u, double choice, Step& step) const;
    bool advance(Path& path, const Ray& ray, const Hit& hit) const;

    const Surfels& surfels_;
    const Tracer& tracer_;
    LightSampler lights_;
    std::uint64_t seed_;
};

// A ray to a light and one that goes on, with the directions of both from u[0..3].
void PathTracer::aim(const Path& path, std::uint32_t index, const double* u, double choice, Step& step) const {
    const Departure& at = path.at;
    if (!lights_.empty()) {
        const LightRay light = lights_.sample(at.position, at.normal, u[2], u[3], choice);
        const Step::Gain gain{index, path.throughput * light.irradiance, light.target};
        if (light.length > 0.0) {
            (light.target == Hit::none ? step.shadow : step.ahead).push_back({at, light.direction, light.length});
            (light.target == Hit::none ? step.shadow_gain : step.ahead_gain).push_back(gain);
        }
    }
    const Frame frame = frame_around(at.normal);
    step.ahead.push_back({at, frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    step.ahead_gain.push_back({index, {}, Hit::none});
}

// Takes the path to where its ray has met something; false where it ends.
bool PathTracer::advance(Path& path, const Ray& ray, const Hit& hit) const {
    if (!hit.front) return false;
    path.throughput = path.throughput * surfels_.reflectance[hit.surfel];
    const double most = std::max({path.throughput.x, path.throughput.y, path.throughput.z});
    if (most <= 0.0) return false;
    const double survival = most / certain_throughput;
    if (survival < 1.0) {
        if (path.random.uniform() >= survival) return false;
        path.throughput *= 1.0 / survival;
    }
    path.at = {ray.from.position + hit.distance * ray.direction, surfels_.normals[hit.surfel], hit.surfel};
    return true;
}

std::size_t PathTracer::trace(const Vec3& point, const Vec3& normal, std::uint64_t stream, const Plan& plan,
                              std::size_t first, std::size_t last, std::vector<Rgb>& sums) const {
    const Departure start = tracer_.departure(point, normal);
    std::vector<Path> paths;
    Step step;
    std::size_t rays = 0;
    sums.assign(last - first, {});
    const auto follow = [&] {
        tracer_.free(step.shadow, step.free);
        tracer_.closest(step.ahead, step.hits);
        rays += step.shadow.size() + step.ahead.size();
        for (std::size_t k = 0; k < step.shadow.size(); ++k)
            if (step.free[k]) sums[paths[step.shadow_gain[k].path].batch] += step.shadow_gain[k].irradiance;
        std::size_t alive = 0;
        for (std::size_t k = 0; k < step.ahead.size(); ++k) {
            const Step::Gain& gain = step.ahead_gain[k];
            const Hit& hit = step.hits[k];
            const Ray& ray = step.ahead[k];
            Path& path = paths[gain.path];
            if (gain.target != Hit::none) {
                if (hit.front && hit.surfel == gain.target) sums[path.batch] += gain.irradiance;
                continue;
            }
            sums[path.batch] += path.throughput * lights_.found(ray.from.position, ray.from.normal, ray.direction, hit);
            // Rays stand in the order of their paths: those that go on move up over those that have ended.
            if (advance(path, ray, hit)) paths[alive++] = path;
        }
        paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(alive), paths.end());
        step.clear();
    };
    for (std::size_t batch = first; batch < last; ++batch) {
        const std::uint64_t own = stream * plan.batches + batch;
        EvenPoints even(4, seed_ + direction_stream, own);
        for (std::size_t k = 0; k < plan.per_batch; ++k) {
            paths.push_back({start,
                             {1, 1, 1},
                             Random(seed_ + choice_stream, own * plan.per_batch + k),
                             static_cast<std::uint32_t>(batch - first)});
            aim(paths.back(), static_cast<std::uint32_t>(paths.size() - 1), even.next(), paths.back().random.uniform(),
                step);
        }
    }
    follow();
    while (!paths.empty()) {
        for (std::uint32_t k = 0; k < paths.size(); ++k) {
            Random& random = paths[k].random;
            double u[5];
            for (double& x : u) x = random.uniform();
            aim(paths[k], k, u, u[4], step);
        }
        follow();
    }
    return rays;
}

}  // namespace

Reference reference_irradiance(const CompiledScene& compiled, const std::vector<Vec3>& points,
                               const std::vector<Vec3>& normals, const ReferenceOptions& options,
                               const Progress& progress) {
    require(points.size() == normals.size(), "normals: wanted one for each of the ", points.size(), " points, got ",
            normals.size());
    require(options.samples >= least_batches, "samples: wanted at least ", least_batches, ", got ", options.samples);
    const Plan plan(options.samples);
    const PathTracer tracer(compiled, options, progress);
    tracer.require_near(points);
    const std::vector<std::uint32_t> order = morton_order(points);
    std::vector<Moments> parts(points.size() * plan.chunks);
    std::vector<std::size_t> rays(parts.size(), 0);
    parallel_blocks(
        parts.size(), 1,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Rgb> sums;
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = order[k / plan.chunks];
                const std::size_t first = k % plan.chunks * plan.per_chunk;
                const std::size_t last = std::min(plan.batches, first + plan.per_chunk);
                rays[k] = tracer.trace(points[i], normals[i], i, plan, first, last, sums);
                for (const Rgb& sum : sums) parts[k].add({1.0, sum / static_cast<double>(plan.per_batch), {}});
            }
        },
        progress);

    Reference out;
    out.batches = plan.batches;
    out.irradiance.resize(points.size());
    out.error.resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        Moments all;
        for (std::size_t part = 0; part < plan.chunks; ++part) {
            all.add(parts[k * plan.chunks + part]);
            out.rays += rays[k * plan.chunks + part];
        }
        const Rgb variance = all.spread / (all.count * (all.count - 1.0));
        out.irradiance[order[k]] = all.mean;
        out.error[order[k]] = {std::sqrt(variance.x), std::sqrt(variance.y), std::sqrt(variance.z)};
    }
    return out;
}

}  // namespace surflux
