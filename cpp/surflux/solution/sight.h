#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/interpolation.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Adjacency for interpolation: places of one object are joined where short shadow rays over the surface between them
// are unoccluded. A floor goes on beneath a thin wall, and its light does not: values interpolated across would leak.
class Sight {
public:
    static constexpr std::uint32_t none = 0xffffffffu;
    struct Place {
        Vec3 position, normal;
        double headroom;  // unoccluded distance along the normal
    };

    // Sites that places are asked about many times over: the headroom of each is found when it is needed, and once.
    class Sites {
    public:
        // Both must outlive this.
        Sites(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals);
        Place place(const Sight& sight, std::uint32_t site) const;

    private:
        const std::vector<Vec3>&positions_, &normals_;
        std::unique_ptr<std::atomic<double>[]> headroom_;  // negative until it is known
    };

    Sight(const Tracer& tracer, const Scene& scene);

    // Distance to what covers a place, along its normal, or infinity.
    double headroom(const Vec3& p, const Vec3& normal) const;
    // Is it so low that hardly any light gets in under it from a distance?
    static bool is_low(double headroom, double distance) { return headroom < 0.02 * distance; }
    // Of all surfels.
    std::vector<Place> places(const Progress& progress) const;
    // Is the way free from one to the other: up from the surface, across, and down again? Two heights are tried, for
    // what lies between two sheets and for what curves; under a cover, half way up to it at most. From under a low
    // one the way to a place without is not free.
    bool joined(const Place& p, const Place& q) const;
    // Is one ray free, from the surface straight up to the air over q? Less than joined() asks for where both are flat.
    bool overlooks(const Vec3& p, const Vec3& normal, const Place& q) const;
    // That, or joined() with a place whose headroom is found where it is needed, once (negative until then).
    bool sees(const Vec3& p, const Vec3& normal, double& headroom_p, const Place& q) const;
    // Drops from the weights at a place the sites that it is not joined with. One that it is known to share the air
    // with (`own`), or else the heaviest that it is joined with, is its anchor: a site whose value is like the
    // anchor's in all channels is taken without asking. False where it is joined with none: the weights are sorted
    // then, heaviest first.
    bool keep_joined(const Vec3& point, const Vec3& normal, const Sites& sites, const std::vector<Rgb>& values,
                     std::vector<Interpolation::Weight>& weights, std::uint32_t own = none) const;

private:
    bool is_own_surface(const Hit& hit, const Vec3& normal) const;
    bool free(const Vec3& from, const Vec3& to, const Vec3& normal_p, const Vec3& normal_q) const;

    const Tracer& tracer_;
    const Scene& scene_;
    std::vector<std::uint32_t> triangles_;  // where those of each surfel begin
};

// Values of which one is less than three quarters of the other.
inline bool differ_much(double a, double b) { return a < 0.75 * b || b < 0.75 * a; }
// In any channel: light of two colours may have one luminance.
inline bool differ_much(const Rgb& a, const Rgb& b) {
    return differ_much(a.x, b.x) || differ_much(a.y, b.y) || differ_much(a.z, b.z);
}

}  // namespace surflux
