#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/light_sampler.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Final gathering where interpolation has no node in sight: irradiance from surfels, estimated by cosine-distributed
// rays that look up the interpolated radiosity where they end. An end with no node in sight either, as inside a column
// that a slab covers, only emits. Small emissive surfels are left to emitted_at().
class FinalGather {
public:
    // `fields` make up the irradiance that is reflected.
    FinalGather(const Scene& scene, const Tracer& tracer, const Sight& sight, const NodalField& nodes,
                const std::vector<Rgb>& light, const std::vector<NodalField::Values>& fields);

    // Irradiance as the mean of `rays`, the same for the same place and seed; `on_backs`: the share of them that backs
    // end.
    Rgb operator()(const Departure& place, int rays, std::uint64_t seed, float* on_backs = nullptr) const;

private:
    Rgb reflected(std::uint32_t surfel, const Vec3& at) const;

    const Scene& scene_;
    const Tracer& tracer_;
    const Sight& sight_;
    const NodalField& nodes_;
    const std::vector<Rgb>& light_;  // of nodes, of all fields
    const std::vector<NodalField::Values>& fields_;
    LightSampler emitters_;
};

}  // namespace surflux
