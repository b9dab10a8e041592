#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/lights.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/emitted_light.h"
#include "surflux/transfer/group_light.h"
#include "surflux/transfer/reflections.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

struct RelightOptions {
    int bounces = 3;                  // fewer than 0: all there are, by GMRES
    std::size_t shadow_rays = 16384;  // of all senders together, for each light
    std::uint64_t seed = 0;
};

// Direct-to-indirect transfer for local lights (L07 sec. 6.5): lights move, the scene stays. Rays from the lights give
// direct irradiance at samples of the senders, nowhere else; the operator, applied once for each bounce, turns what
// they reflect into indirect irradiance everywhere. What departs from L07:
//   - the operator is not multiplied out for several bounces: it is applied again, which takes as long as it takes to
//   read it, and reflectance stays outside, so that it may change, too;
//   - receivers keep irradiance and its gradient by the normal.
class LocalTransfer {
public:
    LocalTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, Figures timings);

    const CompiledScene& scene() const { return *scene_; }
    const TransportOperator& transport() const { return operator_; }
    std::size_t bytes() const { return operator_.bytes(); }
    // Direct irradiance at every surfel from such lights.
    std::vector<Rgb> direct(const std::vector<Light>& lights, const DirectOptions& options, std::uint64_t seed,
                            const Progress& progress) const;
    const EmittedLight& emitted() const { return emitted_; }
    const Figures& timings() const { return timings_; }  // of how it was made

    // Indirect irradiance at every surfel of the scene: what emissive surfels bring, and so many reflections of the
    // light from point, spot, area and directional lights. `reflectance`: of each surfel, or empty for that of the
    // scene.
    std::vector<Rgb> indirect(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance,
                              const RelightOptions& options) const;

private:
    struct Tilted {
        std::vector<float> values, coefs;
    };

    std::shared_ptr<const CompiledScene> scene_;
    TransportOperator operator_;
    Figures timings_;
    SurfelPoints points_;
    GroupLight light_;
    std::vector<float> reflectance_;  // of the leaves of the senders, by node
    EmittedLight emitted_;
    ConnectedLeaves connected_;
    mutable Scratch<Tilted> tilted_;  // megabytes that lamp after lamp would have cleared again
};

}  // namespace surflux
