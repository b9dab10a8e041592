#include "surflux/lights/sample_points.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"
#include "surflux/scene/extent.h"

namespace surflux {

namespace {

// How far apart two computations of one point may end up by the rounding of its coordinates, which in survey
// coordinates is more than any fixed share of a patch.
double rounding_at(const Vec3& p) {
    return 8.0 * std::numeric_limits<double>::epsilon() * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

// Is a patch of two triangles that share a diagonal a parallelogram?
bool as_parallelogram(const Triangle* begin, const Triangle* end, SurfelPoints::Parallelogram& out) {
    if (end - begin != 2) return false;
    const Vec3 p[3] = {begin[0].a, begin[0].b, begin[0].c}, q[3] = {begin[1].a, begin[1].b, begin[1].c};
    for (int k = 0; k < 3; ++k) {
        // p[k] stands opposite the diagonal p[k+1] p[k+2]; the other triangle's odd corner closes the parallelogram.
        const Vec3 fourth = p[(k + 1) % 3] + p[(k + 2) % 3] - p[k];
        int matched = 0;
        bool odd = false;
        for (const Vec3& corner_q : q) {
            if (corner_q == p[(k + 1) % 3] || corner_q == p[(k + 2) % 3])
                ++matched;
            else
                odd = length(corner_q - fourth) < 1e-9 * length(p[(k + 1) % 3] - p[(k + 2) % 3]) + rounding_at(fourth);
        }
        if (matched == 2 && odd) {
            out = {p[k], p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]};
            return true;
        }
    }
    return false;
}

}  // namespace

std::uint64_t stream_of(const Place& place) {
    if (place.is_whole_surfel()) return place.surfel;
    // A hash of the bits of its coordinates: xor-shift and multiplication by 2^64 over the golden ratio.
    std::uint64_t bits = 0x51ed270b;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint64_t word = 0;
        std::memcpy(&word, &place.position[axis], sizeof word);
        bits = (bits ^ (bits >> 29) ^ word) * 0x9e3779b97f4a7c15ull;
    }
    return bits;
}

std::vector<Place> places_of(const Surfels& surfels) {
    std::vector<Place> out(surfels.size());
    for (std::uint32_t i = 0; i < surfels.size(); ++i) out[i] = {surfels.positions[i], surfels.normals[i], i, i};
    return out;
}

SurfelPoints::SurfelPoints(const Surfels& surfels) : surfels_(surfels), up_to_(surfels.triangles.size()) {
    if (!surfels.alone.empty()) reach_.assign(surfels.size(), 0.0f);
    for (std::uint32_t i : surfels.alone)
        reach_[i] = static_cast<float>(surfels.areas.empty() ? surfels.radii[i] : std::sqrt(surfels.areas[i] / pi));
    if (surfels.triangles.empty()) return;
    begin_ = triangle_ranges(surfels);
    kind_.assign(surfels.size(), none);
    inset_.assign(surfels.size(), 0.0f);
    const Extent extent(surfels);
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
        double total = 0.0;
        for (std::uint32_t t = begin_[i]; t < begin_[i + 1]; ++t) up_to_[t] = total += area_of(surfels.triangles[t]);
        if (!is_patch(i)) continue;
        require(total > 0.0, "mesh: the patch of surfel ", i, " has no area");
        for (std::uint32_t t = begin_[i]; t < begin_[i + 1]; ++t) up_to_[t] /= total;
        inset_[i] = static_cast<float>(std::min(0.1, 2.0 * extent.contact_of(i) / std::sqrt(total)));
        Parallelogram found;
        if (as_parallelogram(triangles_begin(i), triangles_end(i), found)) {
            kind_[i] = static_cast<std::uint32_t>(parallelograms_.size());
            parallelograms_.push_back(found);
        }
    }
}

double SurfelPoints::area(std::uint32_t i) const {
    double sum = 0.0;
    for (const Triangle* t = triangles_begin(i); t != triangles_end(i); ++t) sum += area_of(*t);
    return sum;
}

Vec3 SurfelPoints::at(std::uint32_t i, double s, double t) const {
    if (!is_patch(i)) {
        if (!(reach(i) > 0.0)) return surfels_.positions[i];
        const Frame frame = frame_around(surfels_.normals[i]);
        double x, y;
        square_to_disk(s, t, x, y);
        return surfels_.positions[i] + reach(i) * (x * frame.u + y * frame.v);
    }
    if (const Parallelogram* p = parallelogram(i)) return inset(i, p->corner + s * p->u + t * p->v);
    std::uint32_t k = begin_[i];
    double below = 0.0;
    while (k + 1 < begin_[i + 1] && s >= up_to_[k]) below = up_to_[k++];
    const Triangle& triangle = surfels_.triangles[k];
    const Vec3 w = square_to_triangle((s - below) / (up_to_[k] - below), t);
    return inset(i, w.x * triangle.a + w.y * triangle.b + w.z * triangle.c);
}

}  // namespace surflux
