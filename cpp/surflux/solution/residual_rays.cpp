#include "surflux/solution/residual_rays.h"

namespace surflux {

namespace {

constexpr std::uint64_t direction_stream = 0x6a7e85ed, light_stream = 0x119875ed, second_stream = 0x5ec0bd11;

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

void ResidualRays::aim(const Departure& from, const double* u, double choice, const Rgb& throughput, bool is_first,
                       Sources sources) {
    for (int group = 0; group < lights_.groups(); ++group) {
        const LightRay light = lights_.sample(from.position, from.normal, u[0], u[1], choice, group);
        if (!(light.length > 0.0) || (light.is_of_lamp && sources == Sources::no_lamps)) continue;
        light_.add(from, light);
        gain_.push_back({throughput * light.irradiance, light.is_of_lamp, light.target != Hit::none, is_first});
    }
}

// Lamps that are not close take turns where there are more than light samples have groups for.
void ResidualRays::aim_at_lamps(const Receiver& receiver, const std::vector<LampSamples>& samples, const double* u,
                                int round) {
    const int turns = (static_cast<int>(samples.size()) + LightSampler::most_groups - 1) / LightSampler::most_groups;
    for (std::uint32_t k = 0; k < samples.size(); ++k) {
        if (!samples[k].is_close() && (round + static_cast<int>(k)) % turns != 0) continue;
        const LampSample sample = samples[k].sample(u);
        of_lamps_[k].expected += sample.expected, of_lamps_[k].samples += 1;
        const double kernel = sample.arrival.kernel;
        if (!(kernel > 0.0)) continue;
        LightRay ray;
        ray.length = Ray{}.length, ray.direction = sample.arrival.from;
        if (!lamps_[k].distant) {
            const Vec3 way = sample.arrival.from - sample.at;
            ray.length = length(way), ray.direction = way / ray.length;
        }
        light_.add({sample.at, receiver.normal, receiver.surfel}, ray);
        gain_.push_back({{kernel, kernel, kernel}, true, false, true, k});
    }
}

bool ResidualRays::is_near(const Hit& hit) const {
    return hit.distance * hit.distance < near_widths_ * near_widths_ * surfels_.areas[hit.surfel];
}

void ResidualRays::send(const Hit& hit, const Rgb& throughput, Gathered& sum) const {
    if (!hit.front) return;
    const Rgb reflected = throughput * surfels_.reflectance[hit.surfel];
    sum.irradiance += reflected * irradiance_[hit.surfel];
    const std::uint32_t region = regions_.of[hit.surfel];
    sum.from[region] += reflected * regions_.shape(region, irradiance_[hit.surfel]);
}

void ResidualRays::gather(const Place& place, int count, Sequences& sequences, Gathered& sum) {
    const Frame frame = frame_around(place.normal);
    const Receiver receiver{points_, place.surfel, place.shape, place.position, place.normal, place.is_whole_surfel()};
    const bool is_lamp_close = lamps_.any(receiver);
    std::vector<LampSamples> samples;
    for (std::size_t k = 0; k < lamps_.size() && is_lamp_close; ++k) samples.push_back(lamps_.of(k, receiver));
    of_lamps_.assign(samples.size(), {});
    for (int r = 0; r < count && !lights_.empty(); ++r) {
        const double* u = sequences.lights.next();
        const Departure from{points_.at(place, u[2], u[3]), place.normal, place.surfel};
        if (is_lamp_close) {
            aim(from, u, sequences.next_choice(), {1, 1, 1}, true, Sources::no_lamps);
            aim_at_lamps(receiver, samples, u, r);
        } else {
            sum.lamps.unoccluded += lights_.unoccluded(from.position, place.normal);
            aim(from, u, sequences.next_choice(), {1, 1, 1}, true);
        }
    }
    for (int r = 0; r < count; ++r) {
        const double* u = sequences.directions.next();
        const Vec3 from = points_.at(place, u[2], u[3]);
        const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
        const Hit hit = tracer_.closest({{from, place.normal, place.surfel}, direction});
        const Rgb at_end = lights_.found_at_end(place.normal, direction, hit);
        sum.irradiance += at_end;
        sum.of_all += at_end;
        if (!is_lamp_close) {
            sum.lamps.lit += lights_.found_on_way(from, place.normal, direction, hit);
            sum.lamps.all += lights_.found_on_way(from, place.normal, direction, {});
        }
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
        if (gain.lamp != Hit::none) {
            of_lamps_[gain.lamp].all += gain.irradiance.x;
            if (arrives[k]) of_lamps_[gain.lamp].lit += gain.irradiance.x;
        } else if (gain.is_first && gain.is_of_lamp) {
            sum.lamps.all += gain.irradiance;
            if (arrives[k]) sum.lamps.lit += gain.irradiance;
        } else if (arrives[k]) {
            sum.irradiance += gain.irradiance;
            if (!gain.is_first) continue;
            sum.of_all += gain.irradiance;
            if (gain.is_of_surfel) sum.of_surfels += gain.irradiance;
        }
    }
    for (std::size_t k = 0; k < of_lamps_.size(); ++k)
        if (const LampSums& of = of_lamps_[k]; of.all > 0.0)
            sum.lamps.by_themselves += (count * of.expected / of.samples * (of.lit / of.all)) * lamps_[k].color;
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
