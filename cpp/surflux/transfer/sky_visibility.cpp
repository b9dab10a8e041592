#include "surflux/transfer/sky_visibility.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

void SkyVisibility::find(const Place& place, int rays, Scratch& scratch, float* values, float* halves) const {
    const Vec3& normal = place.normal;
    const Frame frame = frame_around(normal);
    EvenPoints even(points_.extends(place) ? 4 : 2, seed_, stream_of(place));
    scratch.rays.clear();
    for (int k = 0; k < rays; ++k) {
        const double* u = even.next();
        const double sine = std::sqrt(std::max(0.0, 1.0 - u[0] * u[0])), phi = 2.0 * pi * u[1];
        const Vec3 local{sine * std::cos(phi), sine * std::sin(phi), u[0]};
        scratch.rays.push_back({{points_.at(place, u[2], u[3]), normal, place.surfel}, frame.to_world(local)});
    }
    tracer_.free(scratch.rays, scratch.free);
    // Of the rays that are free and those that are not the fewer are added up: all, and none, are exact.
    const auto escaped = static_cast<std::size_t>(std::count(scratch.free.begin(), scratch.free.end(), char{1}));
    const bool is_open = 2 * escaped > static_cast<std::size_t>(rays);
    const std::size_t n = size();
    scratch.at.resize(n);
    scratch.sums.assign(2 * n, 0.0);
    for (int k = 0; k < rays; ++k) {
        if ((scratch.free[static_cast<std::size_t>(k)] != 0) == is_open) continue;
        const Vec3& direction = scratch.rays[static_cast<std::size_t>(k)].direction;
        double* sum = scratch.sums.data() + (2 * k < rays ? 0 : n);
        for (const Vec3& d : {direction, direction - 2.0 * dot(direction, normal) * normal}) {
            harmonics_.evaluate(d, scratch.at.data());
            for (std::size_t i = 0; i < n; ++i) sum[i] += scratch.at[i];
        }
    }
    const double of_ray = (is_open ? -2.0 : 2.0) * pi / rays;
    for (std::size_t i = 0; i < n; ++i) {
        const double all = is_open && i == 0 ? std::sqrt(4.0 * pi) : 0.0;
        const double first = scratch.sums[i], second = scratch.sums[n + i];
        values[i] = static_cast<float>(all + of_ray * (first + second));
        if (halves) {
            halves[i] = static_cast<float>(all + 2.0 * of_ray * first);
            halves[n + i] = static_cast<float>(all + 2.0 * of_ray * second);
        }
    }
}

// The mean square is one over the sphere.
VisibilityTest::VisibilityTest(const SurfelPoints& points, const Tracer& tracer, std::uint64_t seed)
    : RowTest(SphericalHarmonics::count(order), static_cast<float>(order / std::sqrt(4.0 * pi))),
      visibility_(points, tracer, order, seed) {}

void VisibilityTest::find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const {
    SkyVisibility::Scratch scratch;
    std::vector<float> all(size());
    for (std::size_t k = begin; k < end; ++k, halves += 2 * size()) {
        const auto rays = static_cast<int>(std::lround(1.0f / of.rows[k].per_ray));
        visibility_.find(of.place(k), rays, scratch, all.data(), halves);
    }
}

}  // namespace surflux
