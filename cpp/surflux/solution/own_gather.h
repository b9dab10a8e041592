#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/scene.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Light from surfels at a place from which none of the nodes around can be seen, so that nothing can be interpolated:
// what rays over its hemisphere meet, with the field at their ends. An end that no node can be seen from, as inside a
// column that a slab covers, only emits.
class OwnGather {
public:
    // `fields` make up the irradiance that is reflected, if any is.
    OwnGather(const Scene& scene, const Tracer& tracer, const Sight& sight, const NodalField& nodes,
              const std::vector<double>& light, const std::vector<NodalField::Values>& fields, bool reflects);

    // The mean of `rays`, the same for the same place and seed.
    Rgb operator()(const Departure& place, int rays, std::uint64_t seed) const;

private:
    Rgb sent(std::uint32_t surfel, const Vec3& at) const;

    const Scene& scene_;
    const Tracer& tracer_;
    const Sight& sight_;
    const NodalField& nodes_;
    const std::vector<double>& light_;  // of nodes, of all fields
    const std::vector<NodalField::Values>& fields_;
    bool reflects_;
};

}  // namespace surflux
