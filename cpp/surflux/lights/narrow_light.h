#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Direct light by light tracing, of disks within whose width it changes: that of a spot whose cone is hardly wider than
// the disks it meets, or of a lamp close over them. Their centres alone would miss it, or take a hair of it for the
// light of all the disk. Its power is known, so rays from the light carry it (particle tracing, Jensen 1996) to the
// surface that they meet first, where the disks share it as they share that surface's area (area/effective_area.h):
// what meets fronts arrives, once.
class NarrowLight {
public:
    struct Part {
        double irradiance = 0.0, error = 0.0;  // per unit of the light's colour; the standard error
    };

    NarrowLight() = default;
    // `rays` for each light, at most.
    NarrowLight(const Scene& scene, const std::vector<Light>& lights, const Tracer& tracer, std::uint64_t seed,
                const Progress& progress = {}, std::size_t rays = std::numeric_limits<std::size_t>::max());

    struct Lit {
        std::uint32_t surfel;
        Part part;
    };
    // Made of no scene.
    bool is_empty() const { return lit_.empty(); }
    // All disks whose centre does not tell what they have of a light, ascending.
    const std::vector<Lit>& lit(std::size_t light) const { return lit_[light]; }
    // Of a disk by light `light`, or null where its centre tells it.
    const Part* of(std::size_t light, std::uint32_t surfel) const;

private:
    std::vector<std::vector<Lit>> lit_;  // of each light, ascending
};

}  // namespace surflux
