#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/lights/glossy_lobe.h"
#include "surflux/lights/sample_points.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// What emissive surfels of a transfer's scene bring, whatever the lights. Rays over the hemisphere seldom meet small
// strong ones, as lamps that are meshes: those are sampled as lights (LightSampler), and the operator carries what they
// light, and what else shines.
class EmittedLight {
public:
    // Both must outlive this.
    EmittedLight(const CompiledScene& scene, const TransportOperator& transport);

    // What leaves send of what is not sampled, by node, `colors` values each.
    const std::vector<float>& sent() const { return sent_; }
    bool any_sampled() const { return any_sampled_; }
    // Irradiance of all surfels by those that are sampled, found when it is first asked for; empty without any.
    const std::vector<Rgb>& at_surfels() const;
    // What the lobes of places send of those that are sampled: places that face the eye, each with its lobe.
    std::vector<Rgb> mirrored(const std::vector<Place>& places, const std::vector<GlossyLobe>& lobes) const;
    // Adds that of the leaves, by node.
    void add_at_leaves(std::vector<float>& direct) const;

private:
    void find() const;

    const CompiledScene& scene_;
    const TransportOperator& operator_;
    std::vector<float> sent_;
    bool any_sampled_ = false;
    mutable std::once_flag once_;
    mutable std::vector<Rgb> at_surfels_;
    mutable std::vector<float> at_leaves_;
};

}  // namespace surflux
