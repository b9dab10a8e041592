#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/sampling.h"
#include "surflux/lights/hemisphere_row.h"

namespace surflux {

// A direction that light is known to come from, and its part of the second moment of what rays bring.
struct Aim {
    Vec3 direction;
    double weight;
};

// A row of rays (lights/hemisphere_row.h) that are denser where light comes from: the cosine-weighted hemisphere is
// divided into cells of equal measure, and each gets rays in proportion to the deviation of what they bring (Neyman
// 1934), at least two. Stratified, so that it is unbiased whatever it was aimed at, and shares still make 1.
struct AimedRow {
    static constexpr int least_rays = 512;
    HemisphereRow found;
    std::vector<std::uint16_t> units;  // that each ray counts for, of `unit` in all
    std::vector<char> first;           // of the first half of a cell's rays
    std::uint32_t unit = 0;
    std::vector<std::uint32_t> density;  // by cell: of rays, over the whole hemisphere

    // Rays of the whole hemisphere, were all of it as dense as it is in this direction.
    double density_towards(const Frame& frame, const Vec3& direction) const;
};

// `count` rays, about; no fewer than two for each cell, AimedRow::least_rays in all.
void gather_aimed_row(const SurfelPoints& points, const Tracer& tracer, const Place& place, int count,
                      const std::vector<Aim>& aims, std::uint64_t seed, AimedRow& out);

}  // namespace surflux
