#include "surflux/transfer/group_oracle.h"

#include <cmath>

#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr int pairs = 8;

}  // namespace

float GroupOracle::unlikeness(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const {
    Random random(seed_, stream);
    const auto place_on_one = [&] {
        const std::uint32_t i = members[static_cast<std::size_t>(random.uniform() * static_cast<double>(count))];
        const double u = random.uniform(), v = random.uniform();
        return Departure{points_.extends(i) ? points_.at(i, u, v) : surfels_.positions[i], surfels_.normals[i], i};
    };
    double sum = 0.0;
    int lit = 0;
    for (int k = 0; k < pairs; ++k) {
        const Departure a = place_on_one(), b = place_on_one();
        const double u = random.uniform(), v = random.uniform(), along = random.uniform();
        const Vec3 direction = frame_around(a.normal).to_world(square_to_cosine_hemisphere(u, v));
        const Hit hit = tracer_.closest(Ray{a, direction});
        const double distance = hit ? along * hit.distance : 0.0;
        if (distant_ ? static_cast<bool>(hit) : !(distance > 0.0)) continue;
        ++lit;
        if (distant_) {
            const double of_a = dot(a.normal, direction), of_b = std::max(0.0, dot(b.normal, direction));
            sum += of_b > 0.0 && tracer_.free(Ray{b, direction}) ? std::abs(of_a - of_b) / (of_a + of_b) : 1.0;
            continue;
        }
        const Vec3 lamp = a.position + distance * direction, to_lamp = lamp - b.position;
        const double squared = length_squared(to_lamp);
        const double of_a = dot(a.normal, direction) / (distance * distance);
        const double of_b =
            squared > 0.0 ? std::max(0.0, dot(b.normal, to_lamp)) / (squared * std::sqrt(squared)) : 0.0;
        if (!(of_a + of_b > 0.0)) continue;
        sum += of_b > 0.0 && tracer_.free(segment(b, lamp)) ? std::abs(of_a - of_b) / (of_a + of_b) : 1.0;
    }
    return lit > 0 ? static_cast<float>(sum / lit) : 0.0f;
}

}  // namespace surflux
