#include "surflux/lights/hemisphere.h"

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t cosine_stream = 1, image_stream = 2;

}  // namespace

Hemispheres measure_hemispheres(const Scene& scene, const Tracer& tracer, int rays, std::uint64_t seed,
                                const Progress& progress) {
    const Surfels& s = scene.surfels;
    const SurfelPoints points(s);
    Rgb constant;
    std::vector<EnvironmentMap> images;
    for (const Light& light : scene.lights)
        if (const auto* environment = std::get_if<Environment>(&light)) {
            if (environment->pixels.empty())
                constant += environment->radiance;
            else
                images.emplace_back(*environment);
        }

    Hemispheres out;
    out.escape.assign(s.size(), 0.0);
    out.absorbed.assign(s.size(), 0.0);
    out.sky.assign(s.size(), {});
    out.rays = s.size() * static_cast<std::size_t>(rays) * (1 + images.size());
    const double share = 1.0 / rays, contact = contact_distance(bounds_of(s));

    const auto measure = [&](std::uint32_t i) {
        const Frame frame = frame_around(s.normals[i]);
        EvenPoints even(points.is_patch(i) ? 4 : 2, seed + cosine_stream, i);
        for (int r = 0; r < rays; ++r) {
            const double* u = even.next();
            const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
            const Hit hit = tracer.closest(i, points.at(i, u[2], u[3]), direction);
            if (hit) {
                // What faces it and touches it covers it; the foot of a wall is as near, but faces elsewhere.
                const bool covered = hit.distance <= contact && dot(frame.n, s.normals[hit.surfel]) < -0.5;
                if (!hit.front || covered) out.absorbed[i] += share;
                continue;
            }
            out.escape[i] += share;
            const double cosine = dot(direction, frame.n);
            for (const EnvironmentMap& image : images)
                out.sky[i] += image.radiance(direction) * (cosine * share / (cosine / pi + image.density(direction)));
        }
        for (std::size_t k = 0; k < images.size(); ++k) {
            EvenPoints lit(points.is_patch(i) ? 4 : 2, seed + image_stream + k, i);
            for (int r = 0; r < rays; ++r) {
                const double* u = lit.next();
                const Vec3 direction = images[k].sample(u[0], u[1]);
                const double cosine = dot(direction, frame.n);
                if (cosine <= 0.0 || !tracer.escapes(i, points.at(i, u[2], u[3]), direction)) continue;
                out.sky[i] +=
                    images[k].radiance(direction) * (cosine * share / (cosine / pi + images[k].density(direction)));
            }
        }
        out.sky[i] += (pi * out.escape[i]) * constant;
    };
    parallel_blocks(
        s.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) measure(static_cast<std::uint32_t>(i));
        },
        progress);
    return out;
}

}  // namespace surflux
