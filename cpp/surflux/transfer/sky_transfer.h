#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/sky_patches.h"
#include "surflux/scene/lights.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/emitted_light.h"
#include "surflux/transfer/reflections.h"
#include "surflux/transfer/sky_irradiance.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Transfer from patches of the sky and the ground (Tregenza and Waters 1983: daylight coefficients): direct light of
// receivers by patches, reflections by the operator, as of lamps. A sun is a light beside them: patches are hundreds of
// times as wide, and its shadows and what it throws through windows would be as wide as they are.
class SkyTransfer {
public:
    // Throws ArgumentError where the direct light is not that of the rows and patches.
    SkyTransfer(std::shared_ptr<const CompiledScene> scene, TransportOperator transport, SkyPatches patches,
                SkyIrradiance direct, Figures timings);

    const TransportOperator& transport() const { return operator_; }
    const SkyPatches& patches() const { return patches_; }
    const SkyIrradiance& direct() const { return direct_; }
    const EmittedLight& emitted() const { return emitted_; }
    const Figures& timings() const { return timings_; }  // of how it was made
    std::size_t bytes() const { return operator_.bytes() + direct_.bytes(); }

    // Direct irradiance of all surfels by other lights, as the sun.
    std::vector<Rgb> sunlight(const std::vector<Light>& lights, const DirectOptions& options, std::uint64_t seed,
                              const Progress& progress) const;
    // At all surfels, under a sky of such radiances of patches, and with `sun` as their direct irradiance by other
    // lights, or none. `bounces`: as sent_after() has it. `reflectance`: of each surfel, or empty for that of the
    // scene.
    struct Irradiance {
        std::vector<Rgb> direct, all;
    };
    Irradiance irradiance(const std::vector<Rgb>& radiances, const std::vector<Rgb>& sun,
                          const std::vector<Rgb>& reflectance, int bounces) const;
    // Irradiance at some surfels by each patch alone, with a radiance of 1: (surfels, patches, 3). What surfels emit is
    // left out.
    std::vector<float> coefficients(const std::vector<std::uint32_t>& surfels, int bounces,
                                    const Progress& progress) const;

private:
    // Coefficients of functions: of direct light, and of all, `channels` interleaved values each.
    struct Fields {
        std::vector<float> direct, all;
    };
    // `besides`: irradiance of the nodes of the senders by other lights, or empty.
    Fields fields(const std::vector<float>& radiances, std::size_t channels, const std::vector<float>& besides,
                  const std::vector<float>& emission, const std::vector<float>& reflectance, int bounces) const;
    std::vector<Rgb> at_surfels(const std::vector<float>& coefs) const;

    std::shared_ptr<const CompiledScene> scene_;
    TransportOperator operator_;
    SkyPatches patches_;
    SkyIrradiance direct_;
    Figures timings_;
    std::vector<float> reflectance_;  // of the leaves of the senders, by node
    EmittedLight emitted_;
    ConnectedLeaves connected_;
};

}  // namespace surflux
