#include "surflux/lights/direct.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "surflux/core/parallel.h"
#include "surflux/core/resize.h"
#include "surflux/core/sampling.h"
#include "surflux/core/size_shares.h"
#include "surflux/core/thread_scratch.h"
#include "surflux/lights/emitter.h"
#include "surflux/lights/narrow_light.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 16, roulette_stream = 0x20171e77e;
constexpr double roulette = 0.25;
constexpr int most_rays = 1 << 20;
constexpr double least_patches = 256.0;  // as many, of equal areas, have options.probes and options.rays each
constexpr double evenness = 0.5;         // of even points' standard error in that of random ones, measured in penumbrae

// Is the way free to a light at a place, or in a direction?
bool is_free(const Tracer& tracer, const Receiver& receiver, const Vec3& at, const Vec3& light, bool distant) {
    const Departure from{at, receiver.normal, receiver.surfel};
    return tracer.free(distant ? Ray{from, light} : segment(from, light));
}

using Part = NarrowLight::Part;

// Mean over the surfel of the irradiance from one light, per unit of its colour: the mean kernel times the share of it
// that gets through, by rays that count as much as passes along them.
Part irradiance_from(const Emitter& light, const Tracer& tracer, const Receiver& receiver, const DirectOptions& options,
                     std::uint64_t seed, std::uint64_t stream) {
    const double mean = light.mean_kernel(receiver);
    if (mean <= 0.0) return {};
    EvenPoints even(4, seed + light_stream, stream);
    double all = 0.0, passed = 0.0;
    int taken = 0, lit = 0, dark = 0;
    thread_local std::vector<Triangle> lit_part;
    const ThreadScratch scratch(lit_part);
    if (receiver.is_patch()) light.find_lit(receiver, lit_part);
    double lit_area = 0.0;
    for (const Triangle& t : lit_part) lit_area += area_of(t);
    const auto point = [&](double s, double t) {
        if (!(lit_area > 0.0)) return receiver.at(s, t);
        const Triangle* part = lit_part.data();
        const Triangle* last = part + lit_part.size() - 1;
        for (s *= lit_area; part != last && s >= area_of(*part); ++part) s -= area_of(*part);
        const Vec3 w = square_to_triangle(std::min(s / area_of(*part), 1.0), t);
        return receiver.points.inset(receiver.shape, w.x * part->a + w.y * part->b + w.z * part->c);
    };
    const auto take = [&](int count) {
        for (; taken < count; ++taken) {
            const double* u = even.next();
            const Vec3 at = point(u[2], u[3]);
            const Arrival arrival = light.arrival(at, receiver.normal, u[0], u[1]);
            if (arrival.kernel <= 0.0) continue;
            const bool free = is_free(tracer, receiver, at, arrival.from, light.distant);
            all += arrival.kernel;
            if (free) passed += arrival.kernel;
            lit += free;
            dark += !free;
        }
    };
    take(light.extended || receiver.is_patch() ? options.probes : 1);
    // What no probe finds may still arrive, by a slit: of those places a share goes on, and speaks for the others. Else
    // what is found takes more rays, which find less, and there is nothing on the other side: the mean of all would be
    // a quarter too low. A single shadow keeps its weight instead, for those that all missed it.
    const bool one_is_dark = dark == 1 && lit > 1;
    double scale = 1.0;
    if (taken > 1 && lit > 0 && dark > 0 && !one_is_dark) {
        take(options.rays);
    } else if (taken > 1 && taken < options.rays && lit == 0 && dark > 0 &&
               Random(seed + roulette_stream, stream).uniform() < roulette) {
        take(options.rays);
        scale = 1.0 / roulette;
    }
    if (!(all > 0.0)) take(options.rays);  // a lamp that hardly rises over the horizon
    if (!(all > 0.0) && lit_part.empty()) return {};
    if (!(all > 0.0)) {
        // A hair of light at the rim of a spot, which no ray found: what of its surroundings sees the spot.
        const int probes = taken;
        for (int k = 0; k < probes; ++k) {
            const double* u = even.next();
            const Vec3 at = point(u[2], u[3]);
            const Arrival arrival = light.arrival(at, receiver.normal, u[0], u[1]);
            lit += is_free(tracer, receiver, at, arrival.from, light.distant);
        }
        return {mean * lit / probes, evenness * mean / std::sqrt(probes)};
    }
    const double share = passed / all;
    const double of_one = options.dark_has_error && lit == 0 && taken > 1 ? 1.0 / taken : 0.0;
    return {scale * mean * share, scale * evenness * mean * std::sqrt(std::max(share, of_one) * (1.0 - share) / taken)};
}

// Rays of patches: a few wide ones carry the light of a whole room, and have more, by their share of the area of those
// that are no wider. Parts have that of their patch, by area.
class RaysOfPatches {
public:
    RaysOfPatches(const Surfels& surfels, const DirectOptions& options)
        : surfels_(surfels), begin_(triangle_ranges(surfels)), options_(options) {
        shares_ = parallel_sum<SizeShares>(surfels.size(), 65536, [&](std::size_t i, SizeShares& shares) {
            shares.add(area(static_cast<std::uint32_t>(i)));
        });
    }
    DirectOptions of(std::uint32_t surfel, double area_of_part) const {
        const double whole = area(surfel), share = whole > 0.0 ? shares_.share(whole) * (area_of_part / whole) : 0.0;
        const auto more = [&](int count) {
            return std::max(count, static_cast<int>(std::min(1.0 * most_rays, share * least_patches * count)));
        };
        DirectOptions out = options_;
        out.probes = more(options_.probes), out.rays = more(options_.rays);
        return out;
    }

private:
    double area(std::uint32_t i) const {
        double sum = 0.0;
        for (std::uint32_t t = begin_[i]; t < begin_[i + 1]; ++t) sum += area_of(surfels_.triangles[t]);
        return sum;
    }
    const Surfels& surfels_;
    std::vector<std::uint32_t> begin_;  // of a surfel's triangles
    DirectOptions options_;
    SizeShares shares_;
};

// Disks, and those inserted in them, which have what the whole one has.
bool is_disk(const SurfelPoints& points, const Place& place) {
    return (place.is_whole_surfel() && !points.is_patch(place.shape)) || (place.is_part && place.shape == Place::point);
}

}  // namespace

std::vector<Rgb> direct_irradiance(const Scene& scene, const Tracer& tracer, const SurfelPoints& points,
                                   const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                   const Progress& progress, std::vector<Rgb>* errors) {
    return direct_irradiance(scene, scene.lights, tracer, points, places, options, seed, progress, errors);
}

std::vector<Rgb> direct_irradiance(const Scene& scene, const std::vector<Light>& from, const Tracer& tracer,
                                   const SurfelPoints& points, const std::vector<Place>& places,
                                   const DirectOptions& options, std::uint64_t seed, const Progress& progress,
                                   std::vector<Rgb>* errors) {
    const auto lights = emitters_of(from);
    std::vector<Rgb> direct;
    resize_with_reports(direct, places.size(), progress);
    if (errors) errors->clear(), resize_with_reports(*errors, places.size(), progress);
    if (lights.empty()) return direct;
    const bool has_disks =
        std::any_of(places.begin(), places.end(), [&](const Place& place) { return is_disk(points, place); });
    const NarrowLight narrow = has_disks ? NarrowLight(scene, from, tracer, seed, progress) : NarrowLight();
    const auto patch = [&](const Place& place) { return place.shape != Place::point && points.is_patch(place.shape); };
    std::optional<RaysOfPatches> rays;
    if (std::any_of(places.begin(), places.end(), patch)) rays.emplace(scene.surfels, options);
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const Place& place = places[k];
                const Receiver receiver{points,         place.surfel, place.shape,
                                        place.position, place.normal, place.is_whole_surfel()};
                Rgb squared;
                const bool as_disk = is_disk(points, place);
                const DirectOptions own =
                    receiver.is_patch() ? rays->of(place.surfel, points.area(place.shape)) : options;
                for (std::size_t l = 0; l < lights.size(); ++l) {
                    const Part* whole = as_disk ? narrow.of(lights[l]->index, place.surfel) : nullptr;
                    const Part part =
                        whole ? *whole : irradiance_from(*lights[l], tracer, receiver, own, seed + l, stream_of(place));
                    direct[k] += part.irradiance * lights[l]->color;
                    squared += (part.error * lights[l]->color) * (part.error * lights[l]->color);
                }
                if (errors) (*errors)[k] = {std::sqrt(squared.x), std::sqrt(squared.y), std::sqrt(squared.z)};
            }
        },
        progress);
    return direct;
}

}  // namespace surflux
