#include "surflux/transfer/places_in_air.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/progress.h"
#include "surflux/core/random.h"
#include "surflux/lights/hemisphere_row.h"

namespace surflux {

namespace {

constexpr int rays_of_place = 32;            // that tell how far it is to what it sees
constexpr std::size_t most_attempts = 1000;  // for each place wanted
constexpr std::size_t attempts_before_halving = 16;
constexpr int looks_around = 32;

// The index of which partial sums rise above a random number.
std::size_t pick(const std::vector<double>& sums, Random& random) {
    const double at = random.uniform() * sums.back();
    return static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end() - 1, at) - sums.begin());
}

bool contains(const Box& box, const Vec3& p) {
    for (int c = 0; c < 3; ++c)
        if (p[c] < box.low[c] || p[c] > box.high[c]) return false;
    return true;
}

// How far it is along a ray until it has left a box; 0 where it does not come there.
double way_through(const Box& box, const Vec3& from, const Vec3& direction) {
    double first = 0.0, last = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
        if (direction[c] == 0.0) {
            if (from[c] < box.low[c] || from[c] > box.high[c]) return 0.0;
            continue;
        }
        const double a = (box.low[c] - from[c]) / direction[c], b = (box.high[c] - from[c]) / direction[c];
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    return first < last ? last : 0.0;
}

// Looks around in directions of a Fibonacci sphere.
bool is_clear(const Tracer& tracer, const Vec3& place, double clearance) {
    constexpr double golden_angle = 2.399963229728653;
    for (int k = 0; k < looks_around; ++k) {
        const double z = (2.0 * k + 1.0) / looks_around - 1.0, r = std::sqrt(1.0 - z * z), phi = golden_angle * k;
        if (tracer.closest({{place, {0.0, 0.0, 1.0}}, {r * std::cos(phi), r * std::sin(phi), z}, clearance}))
            return false;
    }
    return true;
}

}  // namespace

std::vector<double> free_paths(const SurfelPoints& points, const Tracer& tracer, const std::vector<Place>& places,
                               bool of_lamps, std::uint64_t seed, const Progress& progress) {
    std::vector<double> out(places.size());
    const auto length_of = [&](const Hit& hit) {
        if (!of_lamps) return hit ? 0.0 : 1.0;
        return hit ? hit.distance : 0.0;
    };
    parallel_blocks(
        places.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            HemisphereRow row;
            for (std::size_t k = begin; k < end; ++k) {
                gather_row(points, tracer, places[k], rays_of_place, seed, row);
                double sum = 0.0;
                for (const Hit& hit : row.hits) sum += length_of(hit);
                out[k] = sum / rays_of_place;
            }
        },
        progress);
    return out;
}

std::vector<Vec3> places_in_air(const SurfelPoints& points, const Tracer& tracer, const std::vector<Place>& receivers,
                                const std::vector<double>& air, const std::optional<Box>& region, double clearance,
                                std::size_t count, std::uint64_t seed, const Progress& progress) {
    std::vector<double> up_to(air.size());
    std::partial_sum(air.begin(), air.end(), up_to.begin());
    std::vector<Vec3> out;
    if (up_to.empty() || up_to.back() <= 0.0) return out;
    HemisphereRow row;
    for (std::uint64_t k = 0; out.size() < count && k < most_attempts * count; ++k) {
        if (k % 64 == 0) report(progress, out.size(), count);
        Random random(seed, k);
        const Place& place = receivers[pick(up_to, random)];
        gather_row(points, tracer, place, rays_of_place, seed, row);
        // What leaves the scene ends with the region.
        const auto length_of = [&](std::size_t ray) {
            if (row.hits[ray]) return row.hits[ray].distance;
            return region ? way_through(*region, place.position, row.rays[ray].direction) : 0.0;
        };
        std::vector<double> lengths;
        for (std::size_t ray = 0; ray < row.hits.size(); ++ray)
            lengths.push_back((lengths.empty() ? 0.0 : lengths.back()) + length_of(ray));
        const std::size_t ray = pick(lengths, random);
        const Vec3 found = place.position + random.uniform() * length_of(ray) * row.rays[ray].direction;
        const double halvings = static_cast<double>(k / (attempts_before_halving * count));
        if (region && !contains(*region, found)) continue;
        if (is_clear(tracer, found, std::exp2(-halvings) * clearance)) out.push_back(found);
    }
    require(!out.empty(), "region: no surface of the scene sees air in it; wanted where lamps will be");
    return out;
}

}  // namespace surflux
