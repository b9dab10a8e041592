#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Final gathering where interpolation has no node in sight: irradiance from surfels, estimated by cosine-distributed
// rays that look up the interpolated radiosity where they end, and for small emissive surfels by next event estimation,
// too (LightSampler). An end with no node in sight either, as inside a column that a slab covers, only emits.
class FinalGather {
public:
    // `fields` make up the irradiance that is reflected, if any is.
    FinalGather(const Scene& scene, const Tracer& tracer, const Sight& sight, const NodalField& nodes,
                const std::vector<double>& light, const std::vector<NodalField::Values>& fields, bool reflects);

    // Irradiance as the mean of `rays`, the same for the same place and seed.
    Rgb operator()(const Departure& place, int rays, std::uint64_t seed) const;

private:
    Rgb reflected(std::uint32_t surfel, const Vec3& at) const;

    const Scene& scene_;
    const Tracer& tracer_;
    const Sight& sight_;
    const NodalField& nodes_;
    const std::vector<double>& light_;  // of nodes, of all fields
    const std::vector<NodalField::Values>& fields_;
    bool reflects_;
    LightSampler emitters_;
    SurfelPoints points_;
};

}  // namespace surflux
