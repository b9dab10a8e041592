#pragma once

#include <algorithm>
#include <vector>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/core/team.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/reference/batches.h"
#include "surflux/reference/reference.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Paths from given places, all steps of a chunk traced together, whose vertices are of one kind (Kajiya 1986). A Vertex
// says what a place makes of the light that comes to it:
//   LightRay light(lights, at, u, v, choice, group)  a light sample, as what the place makes of it
//   bool onward(at, u, v, random, ray_direction, carried)  where a path goes on, if it does, and what it brings of what
//                                                 it meets
//   Rgb found(lights, ray, hit)                   what the place makes of the light that the ray finds
//   bool advance(surfels, ray, hit, carried, throughput, reach)  makes it the vertex that the ray has met; `reach` is
//                                                 the most that the path can still bring
template <class Vertex>
class PathTracer {
public:
    PathTracer(const CompiledScene& compiled, const ReferenceOptions& options, const Progress& progress)
        : surfels_(compiled.scene().surfels),
          tracer_(compiled.tracer(progress)),
          lights_(compiled.scene(), options.small_emitters),
          seed_(options.seed) {}

    const Tracer& tracer() const { return tracer_; }
    std::uint64_t seed() const { return seed_; }

    // Sums of batches [first, last), each of per_batch paths from the place; returns the number of rays.
    std::size_t trace(const Departure& start, const Vertex& vertex, std::uint64_t stream, const Batches& batches,
                      std::size_t first, std::size_t last, std::vector<Rgb>& sums) const;

private:
    // Roulette begins where a path can bring less than this share of what it meets. Measured on four scenes at 4096
    // samples: 1/16 takes 2.3 to 60 times fewer seconds to the same error than roulette from the second bounce on.
    static constexpr double certain_throughput = 1.0 / 16.0;
    // Far apart, so that runs with seeds next to each other share nothing.
    static constexpr std::uint64_t direction_stream = 0x7ef0000000000000, choice_stream = 0x3c51000000000000;

    struct Path {
        Departure at;
        Vertex vertex;
        Rgb throughput{1, 1, 1};
        Random random;
        std::uint32_t batch;
    };
    // Rays of one step of all paths, and what each brings if it is free, or meets what it wants.
    struct Step {
        struct Gain {
            std::uint32_t path;
            Rgb light;  // of a light sample what it brings, of a ray that goes on what it carries
            std::uint32_t target;
        };
        std::vector<Ray> shadow, ahead;
        std::vector<Gain> shadow_gain, ahead_gain;
        std::vector<char> free;
        std::vector<Hit> hits;
        void clear() { shadow.clear(), ahead.clear(), shadow_gain.clear(), ahead_gain.clear(); }
    };
    void aim(Path& path, std::uint32_t index, const double* u, double choice, Step& step) const;
    bool advance(Path& path, const Ray& ray, const Hit& hit, const Rgb& carried) const;

    const Surfels& surfels_;
    const Tracer& tracer_;
    LightSampler lights_;
    std::uint64_t seed_;
};

// A ray to a light of each group and one that goes on, with the directions of both from u[0..3].
template <class Vertex>
void PathTracer<Vertex>::aim(Path& path, std::uint32_t index, const double* u, double choice, Step& step) const {
    const Departure& at = path.at;
    for (int group = 0; group < lights_.groups(); ++group) {
        const LightRay light = path.vertex.light(lights_, at, u[2], u[3], choice, group);
        const typename Step::Gain gain{index, path.throughput * light.irradiance, light.target};
        if (light.length > 0.0) {
            (light.target == Hit::none ? step.shadow : step.ahead).push_back({at, light.direction, light.length});
            (light.target == Hit::none ? step.shadow_gain : step.ahead_gain).push_back(gain);
        }
    }
    Vec3 direction;
    Rgb carried;
    if (!path.vertex.onward(at, u[0], u[1], path.random, direction, carried)) return;
    step.ahead.push_back({at, direction});
    step.ahead_gain.push_back({index, carried, Hit::none});
}

// Takes the path to where its ray has met something; false where it ends.
template <class Vertex>
bool PathTracer<Vertex>::advance(Path& path, const Ray& ray, const Hit& hit, const Rgb& carried) const {
    if (!hit.front) return false;
    const Rgb reach = path.vertex.advance(surfels_, ray, hit, carried, path.throughput);
    const double most = std::max({reach.x, reach.y, reach.z});
    if (most <= 0.0) return false;
    const double survival = most / certain_throughput;
    if (survival < 1.0) {
        if (path.random.uniform() >= survival) return false;
        path.throughput *= 1.0 / survival;
    }
    path.at = {ray.from.position + hit.distance * ray.direction, surfels_.normals[hit.surfel], hit.surfel};
    return true;
}

template <class Vertex>
std::size_t PathTracer<Vertex>::trace(const Departure& start, const Vertex& vertex, std::uint64_t stream,
                                      const Batches& batches, std::size_t first, std::size_t last,
                                      std::vector<Rgb>& sums) const {
    std::vector<Path> paths;
    Step step;
    std::size_t rays = 0;
    sums.assign(last - first, {});
    const auto follow = [&] {
        tracer_.free(step.shadow, step.free);
        tracer_.closest(step.ahead, step.hits);
        rays += step.shadow.size() + step.ahead.size();
        for (std::size_t k = 0; k < step.shadow.size(); ++k)
            if (step.free[k]) sums[paths[step.shadow_gain[k].path].batch] += step.shadow_gain[k].light;
        std::size_t alive = 0;
        for (std::size_t k = 0; k < step.ahead.size(); ++k) {
            const typename Step::Gain& gain = step.ahead_gain[k];
            const Hit& hit = step.hits[k];
            const Ray& ray = step.ahead[k];
            Path& path = paths[gain.path];
            if (gain.target != Hit::none) {
                if (hit.front && hit.surfel == gain.target) sums[path.batch] += gain.light;
                continue;
            }
            sums[path.batch] += path.throughput * path.vertex.found(lights_, ray, hit);
            // Rays stand in the order of their paths: those that go on move up over those that have ended.
            if (advance(path, ray, hit, gain.light)) paths[alive++] = path;
        }
        paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(alive), paths.end());
        step.clear();
    };
    for (std::size_t batch = first; batch < last; ++batch) {
        const std::uint64_t own = stream * batches.count + batch;
        EvenPoints even(4, seed_ + direction_stream, own);
        for (std::size_t k = 0; k < batches.per_batch; ++k) {
            paths.push_back({start,
                             vertex,
                             {1, 1, 1},
                             Random(seed_ + choice_stream, own * batches.per_batch + k),
                             static_cast<std::uint32_t>(batch - first)});
            const double choice = paths.back().random.uniform();
            aim(paths.back(), static_cast<std::uint32_t>(paths.size() - 1), even.next(), choice, step);
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

// Means over batches, with their standard error, of all places; vertex(i) is that of place i.
template <class Vertex, class MakeVertex>
Reference means_of_paths(const PathTracer<Vertex>& paths, const std::vector<Departure>& places, std::size_t samples,
                         const MakeVertex& vertex, const Progress& progress, const Team& team = {}) {
    const Batches batches(samples);
    std::vector<Vec3> positions;
    positions.reserve(places.size());
    for (const Departure& place : places) positions.push_back(place.position);
    const std::vector<std::uint32_t> order = morton_order(positions);
    std::vector<Moments> parts(places.size() * batches.chunks);
    std::vector<std::size_t> rays(parts.size(), 0);
    const auto digest = [&] { return digest_of_places(paths.seed(), places).value(); };
    shared_blocks(
        team, "paths", digest, parts.size(), 1,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Rgb> sums;
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = order[k / batches.chunks];
                const std::size_t first = k % batches.chunks * batches.per_chunk;
                const std::size_t last = std::min(batches.count, first + batches.per_chunk);
                rays[k] = paths.trace(places[i], vertex(i), i, batches, first, last, sums);
                for (const Rgb& sum : sums) parts[k].add({1.0, sum / static_cast<double>(batches.per_batch), {}});
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            to.add(parts.data() + begin, end - begin);
            to.add(rays.data() + begin, end - begin);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            from.take(parts.data() + begin, end - begin);
            from.take(rays.data() + begin, end - begin);
        },
        progress);

    Reference out;
    out.batches = batches.count;
    out.irradiance.resize(places.size());
    out.error.resize(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
        Moments all;
        for (std::size_t part = 0; part < batches.chunks; ++part) {
            all.add(parts[k * batches.chunks + part]);
            out.rays += rays[k * batches.chunks + part];
        }
        out.irradiance[order[k]] = all.mean;
        out.error[order[k]] = all.error();
    }
    return out;
}

}  // namespace surflux
