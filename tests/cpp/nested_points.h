#pragma once

// Levels of ever denser points on surfaces, for tests of what stands on them.

#include <cmath>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "surflux/core/sampling.h"

namespace surflux::shapes {

struct SurfacePoints {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;

    std::size_t size() const { return positions.size(); }
    void add(const Vec3& position, const Vec3& normal, std::uint32_t object = 0) {
        positions.push_back(position);
        normals.push_back(normal);
        objects.push_back(object);
    }
    void append(const SurfacePoints& other) {
        for (std::size_t i = 0; i < other.size(); ++i) add(other.positions[i], other.normals[i], other.objects[i]);
    }
};

using DrawPoint = std::function<void(Random&, Vec3& position, Vec3& normal)>;

inline void draw_on_square(Random& random, Vec3& position, Vec3& normal) {
    position = {random.uniform(), random.uniform(), 0.0};
    normal = {0, 0, 1};
}

inline void draw_on_sphere(Random& random, Vec3& position, Vec3& normal) {
    const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
    position = normal = {r * std::cos(phi), r * std::sin(phi), z};
}

// The inside of the unit cube.
inline void draw_on_box(Random& random, Vec3& position, Vec3& normal) {
    const int side = static_cast<int>(random.below(6)), axis = side / 2;
    normal = {};
    normal[axis] = side % 2 == 0 ? 1.0 : -1.0;
    position[axis] = side % 2;
    position[(axis + 1) % 3] = random.uniform();
    position[(axis + 2) % 3] = random.uniform();
}

inline SurfacePoints drawn(const DrawPoint& draw, std::size_t count, std::uint64_t seed, std::uint32_t object = 0) {
    Random random(seed, count);
    SurfacePoints out;
    for (std::size_t i = 0; i < count; ++i) {
        Vec3 position, normal;
        draw(random, position, normal);
        out.add(position, normal, object);
    }
    return out;
}

// Poisson disks by darts (L07 sec. 6.1): a level ends after 1000 rejections in a row, the next has half the distance,
// and points of coarser levels count.
inline std::vector<SurfacePoints> nested_points(const DrawPoint& draw, double distance, std::size_t levels,
                                                std::uint64_t seed) {
    std::vector<SurfacePoints> out(levels);
    std::vector<Vec3> all, facing;
    Random random(seed);
    for (std::size_t level = 0; level < levels; ++level, distance *= 0.5) {
        std::unordered_multimap<std::uint64_t, std::size_t> cells;
        const auto cell = [&](const Vec3& p, int dx, int dy, int dz) {
            const auto number = [&](double x, int d) {
                return static_cast<std::uint64_t>(std::floor(x / distance) + d + 1e6);
            };
            return number(p.x, dx) << 42 | number(p.y, dy) << 21 | number(p.z, dz);
        };
        for (std::size_t i = 0; i < all.size(); ++i) cells.emplace(cell(all[i], 0, 0, 0), i);
        for (int rejected = 0; rejected < 1000;) {
            Vec3 position, normal;
            draw(random, position, normal);
            bool free = true;
            for (int k = 0; free && k < 27; ++k) {
                const auto range = cells.equal_range(cell(position, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
                for (auto at = range.first; free && at != range.second; ++at)
                    free = length(all[at->second] - position) >= distance * dot(facing[at->second], normal);
            }
            if (!free) {
                ++rejected;
                continue;
            }
            rejected = 0;
            cells.emplace(cell(position, 0, 0, 0), all.size());
            all.push_back(position);
            facing.push_back(normal);
            out[level].add(position, normal);
        }
    }
    return out;
}

}  // namespace surflux::shapes
