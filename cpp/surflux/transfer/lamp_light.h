#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/lights.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/group_light.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// What point, spot, area and directional lights bring directly to the surfels of a scene, and to the senders of an
// operator.
class LampLight {
public:
    // Both must live as long.
    LampLight(const CompiledScene& scene, const TransportOperator& transport)
        : scene_(scene),
          points_(scene.scene().surfels),
          groups_(scene, transport.senders, transport.samples, points_, transport.areas) {}

    // Irradiance of every surfel.
    std::vector<Rgb> at_surfels(const std::vector<Light>& lights, const DirectOptions& options, std::uint64_t seed,
                                const Progress& progress) const {
        const Scene& scene = scene_.scene();
        return direct_irradiance(scene, lights, scene_.tracer(), points_, places_of(scene.surfels), options, seed,
                                 progress);
    }
    // Of every node of the senders, as GroupLight has it. `reflectance`: by node.
    std::vector<float> at_senders(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                  const GroupLightOptions& options) const {
        return groups_.irradiance(lights, reflectance, options);
    }

private:
    const CompiledScene& scene_;
    SurfelPoints points_;
    GroupLight groups_;
};

}  // namespace surflux
