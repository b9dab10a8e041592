#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Where light is asked for: all of a shape, as SurfelPoints has it, or one place on a surfel, which rays leave.
struct Place {
    static constexpr std::uint32_t point = 0xffffffffu;
    Vec3 position, normal;
    std::uint32_t surfel = 0;
    std::uint32_t shape = point;  // in the SurfelPoints that goes with it
    bool is_part = false;         // of the surfel: shapes are numbered anew, shape k is not surfel k

    bool is_whole_surfel() const { return shape != point && shape == surfel && !is_part; }
};

// A number of its own for the random numbers of each place.
std::uint64_t stream_of(const Place& place);

std::vector<Place> places_of(const Surfels& surfels);

// Points that stand for a surfel: anywhere on its patch where it has triangles, or on the disk of its area where it
// stands alone; its centre where it is a disk among others, because only there the disk is known to touch the surface.
class SurfelPoints {
public:
    explicit SurfelPoints(const Surfels& surfels);

    struct Parallelogram {
        Vec3 corner, u, v;
    };
    // The patch as one, where it is: most patches are.
    const Parallelogram* parallelogram(std::uint32_t i) const {
        return kind_.empty() || kind_[i] == none ? nullptr : &parallelograms_[kind_[i]];
    }

    bool is_patch(std::uint32_t i) const { return first(i) != first(i + 1); }
    // Of a patch, what its triangles have: that of its surfel may have been set.
    double area(std::uint32_t i) const;
    // Has it more points than one?
    bool extends(std::uint32_t i) const { return is_patch(i) || reach(i) > 0.0; }
    // Uniform over the patch for (s, t) uniform in the unit square.
    Vec3 at(std::uint32_t i, double s, double t) const;
    bool extends(const Place& place) const { return place.shape != Place::point && extends(place.shape); }
    Vec3 at(const Place& place, double s, double t) const {
        return extends(place) ? at(place.shape, s, t) : place.position;
    }
    // A point of the patch, drawn in from its rim as those of at() are.
    Vec3 inset(std::uint32_t i, const Vec3& p) const {
        return p + static_cast<double>(inset_[i]) * (surfels_.positions[i] - p);
    }
    const Triangle* triangles_begin(std::uint32_t i) const { return surfels_.triangles.data() + first(i); }
    const Triangle* triangles_end(std::uint32_t i) const { return surfels_.triangles.data() + first(i + 1); }

private:
    static constexpr std::uint32_t none = 0xffffffffu;
    std::uint32_t first(std::uint32_t i) const { return begin_.empty() ? 0 : begin_[i]; }  // of its triangles
    double reach(std::uint32_t i) const { return reach_.empty() ? 0.0 : static_cast<double>(reach_[i]); }

    const Surfels& surfels_;
    // Empty where there are no patches, as all that is of those alone.
    std::vector<std::uint32_t> begin_;
    std::vector<std::uint32_t> kind_;  // index of the parallelogram, or none
    std::vector<Parallelogram> parallelograms_;
    std::vector<double> up_to_;  // per triangle: share of its patch's area up to and with it
    // By how much points are drawn in from the rim of the patch: on it, float rounding would put some of them behind
    // the next wall.
    std::vector<float> inset_;
    std::vector<float> reach_;  // radius of the disk of its area, where it stands alone; else 0, empty where none does
};

}  // namespace surflux
