#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/emitted_light.h"
#include "surflux/transfer/spherical_harmonics.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Radiance that comes to the surfels of a scene, by spherical harmonics in the scene's axes: from afar, and from other
// surfels, which is smoother and has fewer of them; of small strong emissive surfels by light samples (EmittedLight).
// Below the horizon it goes on as SkyVisibility does.
class IncidentLight {
public:
    static constexpr int distant_order = 9, reflected_order = 5;
    static constexpr std::size_t distant = SphericalHarmonics::count(distant_order),
                                 reflected = SphericalHarmonics::count(reflected_order),
                                 channels = 3 * (distant + reflected);

    // `coefficients`: for each function of the operator, `channels`: red, green and blue of the harmonics of distant
    // light, one after another, then those of reflected light.
    IncidentLight(std::shared_ptr<const CompiledScene> scene, std::shared_ptr<const TransportOperator> transport,
                  std::shared_ptr<const EmittedLight> emitted, std::vector<float> coefficients)
        : scene_(std::move(scene)),
          transport_(std::move(transport)),
          emitted_(std::move(emitted)),
          coefficients_(std::move(coefficients)) {}

    // At surfels, by their own normals; below 0 where the light is.
    struct Irradiance {
        std::vector<Rgb> distant, all;
    };
    Irradiance irradiance() const;
    // What comes back of a unit of specular reflectance around the mirror images of unit directions, one for each
    // surfel: the lobe of GlossyLobe. 0 from behind, and where a sum of harmonics rings below 0 around what is small
    // and bright.
    std::vector<Rgb> mirrored(const std::vector<Vec3>& directions, const std::vector<double>& exponents) const;

private:
    void add_emitted(const std::vector<Vec3>& directions, const std::vector<double>& exponents,
                     std::vector<Rgb>& out) const;
    template <class Visit>
    void for_surfels(const Visit& visit) const;

    std::shared_ptr<const CompiledScene> scene_;
    std::shared_ptr<const TransportOperator> transport_;
    std::shared_ptr<const EmittedLight> emitted_;
    std::vector<float> coefficients_;
};

}  // namespace surflux
