#include "surflux/solution/residual_rays.h"

namespace surflux {

namespace {

constexpr std::uint64_t direction_stream = 0x6a7e85ed, light_stream = 0x119875ed, second_stream = 0x5ec0bd11;
// Widths of a surfel within which the light across it is not taken as one value.
constexpr double near_widths = 2.0;

}  // namespace

ResidualRays::Sequences::Sequences(std::uint64_t seed, std::uint64_t stream)
    : directions(4, seed + direction_stream, stream),
      lights(4, seed + light_stream, stream),
      random(seed + second_stream, stream),
      choice_(random.uniform()) {}

double ResidualRays::Sequences::next_choice() {
    constexpr double golden = 0.6180339887498949;  // evenest of multiples modulo 1, and of no base
    choice_ += choice_ < 1.0 - golden ? golden : golden - 1.0;
    return choice_;
}

void ResidualRays::aim(const Departure& from, const double* u, double choice, const Rgb& throughput, bool is_first) {
    for (int group = 0; group < lights_.groups(); ++group) {
        const LightRay light = lights_.sample(from.position, from.normal, u[0], u[1], choice, group);
        if (!(light.length > 0.0)) continue;
        light_.add(from, light);
        gain_.push_back({throughput * light.irradiance, light.is_of_lamp, light.target != Hit::none, is_first});
    }
}

bool ResidualRays::is_near(const Hit& hit) const {
    return hit.distance * hit.distance < near_widths * near_widths * surfels_.areas[hit.surfel];
}

void ResidualRays::send(const Hit& hit, const Rgb& throughput, Gathered& sum) const {
    if (!hit.front) return;
    const Rgb reflected = throughput * surfels_.reflectance[hit.surfel];
    sum.irradiance += reflected * irradiance_[hit.surfel];
    sum.from[regions_.of[hit.surfel]] += reflected;
}

void ResidualRays::gather(const Place& place, int count, Sequences& sequences, Gathered& sum) {
    const Frame frame = frame_around(place.normal);
    for (int r = 0; r < count && !lights_.empty(); ++r) {
        const double* u = sequences.lights.next();
        const Vec3 from = points_.at(place, u[2], u[3]);
        sum.lamps.unoccluded += lights_.unoccluded(from, place.normal);
        aim({from, place.normal, place.surfel}, u, sequences.next_choice(), {1, 1, 1}, true);
    }
    for (int r = 0; r < count; ++r) {
        const double* u = sequences.directions.next();
        const Vec3 from = points_.at(place, u[2], u[3]);
        const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
        const Hit hit = tracer_.closest({{from, place.normal, place.surfel}, direction});
        const Rgb at_end = lights_.found_at_end(place.normal, direction, hit);
        sum.irradiance += at_end;
        sum.of_all += at_end;
        sum.lamps.lit += lights_.found_on_way(from, place.normal, direction, hit);
        sum.lamps.all += lights_.found_on_way(from, place.normal, direction, {});
        if (!hit.front) {
            sum.lost += 1.0;
            continue;
        }
        const Rgb reflected = surfels_.reflectance[hit.surfel] * irradiance_[hit.surfel];
        sum.met[regions_.of[hit.surfel]] += 1.0;
        sum.of_surfels += at_end + reflected;
        sum.of_all += reflected;
        if (surfels_.reflectance[hit.surfel] == Rgb{}) continue;
        if (!is_near(hit)) {
            send(hit, {1, 1, 1}, sum);
            continue;
        }
        const Departure at{from + hit.distance * direction, surfels_.normals[hit.surfel], hit.surfel};
        double v[5];
        for (double& x : v) x = sequences.random.uniform();
        if (!lights_.empty()) aim(at, v, v[2], surfels_.reflectance[hit.surfel], false);
        ahead_.push_back({at, frame_around(at.normal).to_world(square_to_cosine_hemisphere(v[3], v[4]))});
        ahead_throughput_.push_back(surfels_.reflectance[hit.surfel]);
    }
    rays += static_cast<std::size_t>(count) + light_.size() + ahead_.size();
    const std::vector<char>& arrives = light_.trace(tracer_);
    for (std::size_t k = 0; k < gain_.size(); ++k) {
        const Gain& gain = gain_[k];
        if (gain.is_first && gain.is_of_lamp) {
            sum.lamps.all += gain.irradiance;
            if (arrives[k]) sum.lamps.lit += gain.irradiance;
        } else if (arrives[k]) {
            sum.irradiance += gain.irradiance;
            if (!gain.is_first) continue;
            sum.of_all += gain.irradiance;
            if (gain.is_of_surfel) sum.of_surfels += gain.irradiance;
        }
    }
    tracer_.closest(ahead_, hits_);
    for (std::size_t k = 0; k < ahead_.size(); ++k) {
        const Ray& ray = ahead_[k];
        sum.irradiance +=
            ahead_throughput_[k] * lights_.found(ray.from.position, ray.from.normal, ray.direction, hits_[k]);
        send(hits_[k], ahead_throughput_[k], sum);
    }
    light_.clear(), gain_.clear();
    ahead_.clear(), ahead_throughput_.clear();
}

}  // namespace surflux
