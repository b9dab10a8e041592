#include "surflux/transfer/group_oracle.h"

#include <cmath>

#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr int pairs = 8;

}  // namespace

SenderGroups::Lit GroupOracle::unlikeness(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const {
    Random random(seed_, stream);
    const auto draw = [&](std::size_t of) {
        return static_cast<std::size_t>(random.uniform() * static_cast<double>(of));
    };
    const auto place_on = [&](std::size_t member) {
        const std::uint32_t i = members[member];
        const double u = random.uniform(), v = random.uniform();
        return Departure{points_.extends(i) ? points_.at(i, u, v) : surfels_.positions[i], surfels_.normals[i], i};
    };
    double sum = 0.0;
    int lit = 0;
    bool parted = false;
    // `free`: is what faces the lamp unoccluded?
    const auto add = [&](double of_a, double of_b, const auto& free) {
        const bool hidden = of_b > 0.0 && !free();
        parted |= hidden;
        sum += of_b > 0.0 && !hidden ? std::abs(of_a - of_b) / (of_a + of_b) : 1.0;
    };
    for (int k = 0; k < pairs; ++k) {
        const Departure a = place_on(draw(count)), b = place_on(draw(count));
        const double u = random.uniform(), v = random.uniform(), along = random.uniform();
        const Vec3 direction = frame_around(a.normal).to_world(square_to_cosine_hemisphere(u, v));
        const Hit hit = tracer_.closest(Ray{a, direction});
        const double distance = hit ? along * hit.distance : 0.0;
        if (distant_ ? static_cast<bool>(hit) : !(distance > 0.0)) continue;
        ++lit;
        if (distant_) {
            const double of_a = dot(a.normal, direction), of_b = std::max(0.0, dot(b.normal, direction));
            add(of_a, of_b, [&] { return tracer_.free(Ray{b, direction}); });
            continue;
        }
        const Vec3 lamp = a.position + distance * direction, to_lamp = lamp - b.position;
        const double squared = length_squared(to_lamp);
        const double of_a = dot(a.normal, direction) / (distance * distance);
        const double of_b =
            squared > 0.0 ? std::max(0.0, dot(b.normal, to_lamp)) / (squared * std::sqrt(squared)) : 0.0;
        if (!(of_a + of_b > 0.0)) continue;
        add(of_a, of_b, [&] { return tracer_.free(segment(b, lamp)); });
    }
    // What stands between two that are next to each other hides lamps close to one of them.
    for (int k = 0; k < pairs && !parted && count > 1; ++k) {
        const std::size_t one = draw(count), other = (one + 1 + draw(count - 1)) % count;
        const Departure a = place_on(one), b = place_on(other);
        const double u = random.uniform(), v = random.uniform(), along = random.uniform();
        const Vec3 direction = frame_around(a.normal).to_world(square_to_cosine_hemisphere(u, v));
        const Hit hit = tracer_.closest(Ray{a, direction, length(b.position - a.position)});
        const Vec3 lamp = a.position + along * (hit ? hit.distance : length(b.position - a.position)) * direction;
        parted = dot(b.normal, lamp - b.position) > 0.0 && !tracer_.free(segment(b, lamp));
    }
    return {lit > 0 ? static_cast<float>(sum / lit) : 0.0f, parted};
}

}  // namespace surflux
