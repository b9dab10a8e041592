#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/incident_light.h"
#include "surflux/transfer/reflections.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Glossy transfer from distant light (L07 sec. 6.4, after Sloan, Kautz and Snyder 2002): from the spherical harmonics
// of an environment to those of the radiance that comes to each surfel, shadows and reflections in it. What departs
// from L07, which keeps a matrix of 25 x 25 for each point:
//   - "times visibility" is such a matrix, and 169 harmonics of visibility say all of it, for 81 of incident light;
//   - reflections are products of the operator at run time, as of LocalTransfer, so that reflectance may change;
//   - visibility goes on below the horizon, which is taken off with the normal of the surfel, so that points need not
//   be dense where surfaces are bent.
class DistantTransfer {
public:
    static constexpr int source_order = 5;  // of the environment
    static constexpr int visibility_order = source_order + IncidentLight::distant_order - 1;

    // Of each row, visibility_order^2 harmonics, times the scale of the row.
    struct Visibility {
        std::vector<std::int16_t> values;
        std::vector<float> scale;
    };
    // Throws ArgumentError where the visibility is not that of the rows.
    DistantTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, Visibility visibility,
                    Figures timings);

    const TransportOperator& transport() const { return *operator_; }
    const Visibility& visibility() const { return visibility_; }
    const EmittedLight& emitted() const { return *emitted_; }
    const Figures& timings() const { return timings_; }  // of how it was made
    std::size_t bytes() const;

    // Under an environment of source_order^2 harmonics. `bounces`: as sent_after() has it. `reflectance`: of each
    // surfel, or empty for that of the scene.
    IncidentLight incident(const std::vector<Rgb>& environment, const std::vector<Rgb>& reflectance, int bounces) const;

private:
    std::shared_ptr<const CompiledScene> scene_;
    std::shared_ptr<const TransportOperator> operator_;
    Figures timings_;
    Visibility visibility_;
    std::vector<float> reflectance_;  // of the leaves of the senders, by node
    std::shared_ptr<const EmittedLight> emitted_;
    ConnectedLeaves connected_;
};

// What the rows of an operator see of the sky, by so many rays each.
DistantTransfer::Visibility find_visibility(const TransportOperator& transport, const SurfelPoints& points,
                                            const Tracer& tracer, int rays, std::uint64_t seed,
                                            const Progress& progress, const Team& team = {});

}  // namespace surflux
