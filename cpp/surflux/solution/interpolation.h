#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Scattered-data interpolation on surfaces by modified Shepard weights (Franke and Little), ((h - d) / (h d))^2, over
// the nearest sites of the same object that face about the same way, h being the distance at which the farthest of them
// drops out: a positive partition of unity, 1 at its own site, with supports that follow the density of sites. What
// lies off the surface, behind or before it, counts as farther.
class Interpolation {
public:
    static constexpr std::uint32_t any_object = 0xffffffffu;
    static constexpr std::size_t most_sites = 9;  // that a place is interpolated from; the last has weight 0
    struct Weight {
        std::uint32_t site;
        double weight;
    };

    Interpolation(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                  const std::vector<std::uint32_t>& objects, const Progress& progress = {});
    ~Interpolation();
    Interpolation(const Interpolation&) = delete;
    Interpolation& operator=(const Interpolation&) = delete;

    // Weights at a point of an object, or of that object whose surface is nearest. Where no site faces its way, the
    // nearest alone. Queries are const and may run on many threads at once.
    void at(const Vec3& point, const Vec3& normal, std::uint32_t object, std::vector<Weight>& out) const;
    // The nearest sites, at most `count`, that a point is interpolated from, and no weights; nearest first.
    void nearest(const Vec3& point, const Vec3& normal, std::uint32_t object, std::size_t count,
                 std::vector<Weight>& out) const;

private:
    struct Object;
    const std::vector<Vec3>& positions_;
    const std::vector<Vec3>& normals_;
    std::vector<Object> objects_;
    std::vector<std::uint32_t> place_;  // of an object's number in objects_
};

}  // namespace surflux
