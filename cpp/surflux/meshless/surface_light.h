#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance that needs no solving: from lights, and by next event estimation towards small emissive surfels and images
// of the sky, of the latter the light-sampling part alone (LightSampler::found has the other). What emissive surfels
// bring rises steeply towards them and makes all other light: a basis that was as fine as that light asks for would not
// carry their power, so it is had at each surfel, as that of lamps.
class SurfaceLight {
public:
    // At every surfel of the scene: the mean over a patch, at the centre of a disk.
    SurfaceLight(const Scene& scene, const Tracer& tracer, const DirectOptions& options, int aimed_rays,
                 std::uint64_t seed, const Progress& progress);

    const LightSampler& emitters() const { return emitters_; }
    const LightSampler& skies() const { return skies_; }
    const SurfelPoints& points() const { return points_; }

    Rgb at_surfel(std::size_t i) const { return surfels_.lights[i] + surfels_.sky[i] + surfels_.emitters[i]; }
    // The part of it that comes from lights and Environments.
    Rgb direct_at_surfel(std::size_t i) const { return surfels_.lights[i] + surfels_.sky[i]; }
    const Rgb& emitted_at_surfel(std::size_t i) const { return surfels_.emitters[i]; }
    bool is_dark() const { return all_.empty(); }

    struct At {
        std::vector<Rgb> lights, sky, emitters;
    };
    // At places on surfaces.
    At at(const std::vector<Place>& places, const Progress& progress) const;

    // One ray that brings, in the mean over u, all of at_surfel() that there is at one point, but what a
    // cosine-distributed ray from there finds of emitters().
    LightRay towards(const Vec3& point, const Vec3& normal, const double (&u)[3]) const {
        return all_.sample(point, normal, u[0], u[1], u[2]);
    }

private:
    const Scene& scene_;
    const Tracer& tracer_;
    DirectOptions options_;
    int aimed_rays_;
    std::uint64_t seed_;
    SurfelPoints points_;
    LightSampler all_, emitters_, skies_;
    At surfels_;
};

}  // namespace surflux
