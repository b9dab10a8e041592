#include "surflux/transfer/group_oracle.h"

#include <cmath>
#include <utility>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr int pairs = 8;
// Of two halves. Of those whose places face each other's lamps, so many at least, how many may see them: rays from
// closer to a wall than floats tell start beyond it.
constexpr int pairs_across = 16, least_facing = 4;
constexpr double most_seen = 0.125;
constexpr std::uint64_t across_stream = 0x7a11;

std::size_t draw(std::size_t of, Random& random) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(of));
}

}  // namespace

Departure GroupOracle::place_on(std::uint32_t i, Random& random) const {
    const double u = random.uniform(), v = random.uniform();
    return {points_.extends(i) ? points_.at(i, u, v) : surfels_.positions[i], surfels_.normals[i], i};
}

Vec3 GroupOracle::free_way(const Departure& from, double most, double u, double v) const {
    const Vec3 direction = frame_around(from.normal).to_world(square_to_cosine_hemisphere(u, v));
    const Hit hit = tracer_.closest(Ray{from, direction, most});
    return (hit ? hit.distance : most) * direction;
}

SenderGroups::Lit GroupOracle::unlikeness(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const {
    Random random(seed_, stream);
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
        const Departure a = place_on(members[draw(count, random)], random),
                        b = place_on(members[draw(count, random)], random);
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
        const std::size_t one = draw(count, random), other = (one + 1 + draw(count - 1, random)) % count;
        const Departure a = place_on(members[one], random), b = place_on(members[other], random);
        const double u = random.uniform(), v = random.uniform(), along = random.uniform();
        const Vec3 lamp = a.position + along * free_way(a, length(b.position - a.position), u, v);
        parted = dot(b.normal, lamp - b.position) > 0.0 && !tracer_.free(segment(b, lamp));
    }
    return {lit > 0 ? static_cast<float>(sum / lit) : 0.0f, parted};
}

bool GroupOracle::walled(const std::uint32_t* members, std::size_t middle, std::size_t count,
                         std::uint64_t stream) const {
    Random random(seed_ + across_stream, stream);
    const auto center = [&](std::size_t member) {
        const std::uint32_t i = members[member];
        return Departure{surfels_.positions[i], surfels_.normals[i], i};
    };
    int facing = 0, seen = 0;
    for (int k = 0; k < pairs_across && seen <= most_seen * pairs_across; ++k) {
        Departure a = center(draw(middle, random)), b = center(middle + draw(count - middle, random));
        if (k % 2 == 1) std::swap(a, b);
        const double u = random.uniform(), v = random.uniform();
        const Vec3 lamp = a.position + 0.5 * free_way(a, length(b.position - a.position), u, v);
        if (!(dot(b.normal, lamp - b.position) > 0.0)) continue;
        ++facing;
        seen += tracer_.free(segment(b, lamp));
    }
    return facing >= least_facing && seen <= most_seen * facing;
}

}  // namespace surflux
