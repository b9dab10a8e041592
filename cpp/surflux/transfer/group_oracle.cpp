#include "surflux/transfer/group_oracle.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <tuple>
#include <utility>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr int pairs = 8;
// Of two halves. Of those whose places face each other's lamps, so many at least, how many may see them: rays from
// closer to a wall than floats tell start beyond it.
constexpr int pairs_across = 16, least_facing = 4;
constexpr double most_seen = 0.125;
constexpr std::uint64_t across_stream = 0x7a11, sides_stream = 0x51de;
// What of a large group is looked at for its sides, and by how many of those near it whatever it may be is to be seen.
constexpr std::size_t most_marks = 128;
constexpr int most_ways = 4;
constexpr double out_of_folds = 8.0;  // times as far as two are from each other, lamps that are between no folds

std::size_t draw(std::size_t of, Random& random) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(of));
}

}  // namespace

// By the light that is expected on them or, `unusual`, by how far that is from the mean of all.
class GroupOracle::Draw {
public:
    Draw(const GroupOracle& oracle, const std::uint32_t* members, std::size_t count, bool unusual) : count_(count) {
        const std::vector<double>&light = oracle.light_, &areas = oracle.surfels_.areas;
        if (light.empty()) return;
        double all = 0.0, area = 0.0;
        for (std::size_t k = 0; k < count && unusual; ++k) {
            all += areas[members[k]] * light[members[k]];
            area += areas[members[k]];
        }
        const double mean = area > 0.0 ? all / area : 0.0;  // 0 where not unusual ones are drawn
        up_to_.resize(count);
        double sum = 0.0;
        for (std::size_t k = 0; k < count; ++k)
            up_to_[k] = sum += areas[members[k]] * std::abs(light[members[k]] - mean);
        if (!(sum > 0.0)) up_to_.clear();
    }
    std::size_t operator()(Random& random) const {
        if (up_to_.empty()) return draw(count_, random);
        return static_cast<std::size_t>(
            std::upper_bound(up_to_.begin(), up_to_.end() - 1, random.uniform() * up_to_.back()) - up_to_.begin());
    }

private:
    std::size_t count_;
    std::vector<double> up_to_;  // empty where all are drawn alike
};

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
    const Draw expected(*this, members, count, false);
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
        const Departure a = place_on(members[expected(random)], random),
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
        const std::size_t one = expected(random), other = (one + 1 + draw(count - 1, random)) % count;
        const Departure a = place_on(members[one], random), b = place_on(members[other], random);
        const double u = random.uniform(), v = random.uniform(), along = random.uniform();
        const Vec3 lamp = a.position + along * free_way(a, length(b.position - a.position), u, v);
        parted = dot(b.normal, lamp - b.position) > 0.0 && !tracer_.free(segment(b, lamp));
    }
    return {lit > 0 ? static_cast<float>(sum / lit) : 0.0f, parted};
}

GroupOracle::Seen GroupOracle::see(const Departure& from, const Departure& lit, double reach, Random& random) const {
    const double u = random.uniform(), v = random.uniform();
    const Vec3 lamp = from.position + 0.5 * free_way(from, reach * length(lit.position - from.position), u, v);
    if (!(dot(lit.normal, lamp - lit.position) > 0.0)) return Seen::behind;
    return tracer_.free(segment(lit, lamp)) ? Seen::yes : Seen::no;
}

bool GroupOracle::walled(const std::uint32_t* members, std::size_t middle, std::size_t count, std::uint64_t stream,
                         double reach) const {
    Random random(seed_ + across_stream, stream);
    int facing = 0, seen = 0;
    for (int k = 0; k < pairs_across && seen <= most_seen * pairs_across; ++k) {
        Departure a = center_of(members[draw(middle, random)]),
                  b = center_of(members[middle + draw(count - middle, random)]);
        if (k % 2 == 1) std::swap(a, b);
        const Seen of_lamp = see(a, b, reach, random);
        facing += of_lamp != Seen::behind;
        seen += of_lamp == Seen::yes;
    }
    return facing >= least_facing && seen <= most_seen * facing;
}

GroupOracle::Parts GroupOracle::parts(const std::vector<std::uint32_t>& surfels, Random& random) const {
    struct Way {
        double squared;
        std::size_t from, to;
        bool operator>(const Way& other) const {
            return std::tie(squared, from, to) > std::tie(other.squared, other.from, other.to);
        }
    };
    constexpr std::size_t none = ~std::size_t{0};
    Parts out{std::vector<std::size_t>(surfels.size(), none)};
    std::size_t left = surfels.size();
    for (std::size_t first = 0; first < surfels.size(); ++first) {
        if (out.of[first] != none) continue;
        std::vector<Way> open;  // a heap, the shortest first
        std::vector<int> ways(surfels.size(), 0);
        const auto reach = [&](std::size_t from) {
            out.of[from] = out.count;
            --left;
            for (std::size_t to = 0; to < surfels.size(); ++to) {
                if (out.of[to] != none || ways[to] == most_ways) continue;
                const Vec3 between = surfels_.positions[surfels[to]] - surfels_.positions[surfels[from]];
                open.push_back({length_squared(between), from, to});
                std::push_heap(open.begin(), open.end(), std::greater<Way>());
            }
        };
        for (reach(first); !open.empty() && left > 0;) {
            std::pop_heap(open.begin(), open.end(), std::greater<Way>());
            const Way way = open.back();
            open.pop_back();
            if (out.of[way.to] != none || ways[way.to] == most_ways) continue;
            ++ways[way.to];
            const Seen of_lamp = see(center_of(surfels[way.from]), center_of(surfels[way.to]), 1.0, random);
            if (of_lamp == Seen::yes) reach(way.to);
            out.hidden |= of_lamp == Seen::no;
        }
        ++out.count;
    }
    return out;
}

SenderGroups::Sides GroupOracle::sides(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const {
    Random random(seed_ + sides_stream, stream);
    if (count > most_marks) {  // half of the marks where other light is expected than around
        const Draw unusual(*this, members, count, true);
        std::vector<std::uint32_t> marks;
        for (std::size_t k = 0; k < most_marks; ++k)
            marks.push_back(members[k % 2 == 0 ? draw(count, random) : unusual(random)]);
        std::sort(marks.begin(), marks.end());
        marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
        // By what stands between those that are farther apart, too: halves tell.
        return {parts(marks, random).hidden, {}, false};
    }
    const Parts found = parts({members, members + count}, random);
    // One that a wall surrounds, whatever hides the others from each other.
    for (std::size_t k = 0; k < found.count && found.count > 1; ++k) {
        SenderGroups::Sides out{true, std::vector<char>(count), true};
        std::vector<std::uint32_t> parted, others;
        for (std::size_t i = 0; i < count; ++i) {
            out.of[i] = found.of[i] == k ? '\0' : '\1';
            (found.of[i] == k ? parted : others).push_back(members[i]);
        }
        const std::size_t middle = parted.size();
        parted.insert(parted.end(), others.begin(), others.end());
        if (walled(parted.data(), middle, count, stream, out_of_folds)) return out;
    }
    return {};
}

SenderGroups::Walls GroupOracle::walls(bool of_halves) const {
    SenderGroups::Walls out;
    if (of_halves)
        out.halves = [this](const std::uint32_t* members, std::size_t middle, std::size_t count, std::uint64_t stream) {
            return walled(members, middle, count, stream);
        };
    out.sides = [this](const std::uint32_t* members, std::size_t count, std::uint64_t stream) {
        return sides(members, count, stream);
    };
    return out;
}

}  // namespace surflux
