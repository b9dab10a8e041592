#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/sampling.h"
#include "surflux/core/team.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/sky_cells.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance that needs no solving: from lights, from images of the sky, and by next event estimation towards small
// emissive surfels; the sky of one colour is found by hemisphere rays (skies()). What emissive surfels bring rises
// steeply towards them and makes all other light. However finely it is refined, the basis would not carry the power of
// that, so it is kept at each surfel, "beside the basis"; what lights bring is kept there, too, unless
// `lights_in_basis`.
class SurfaceLight {
public:
    // At every surfel of the scene: the mean over a patch, at the centre of a disk.
    SurfaceLight(const Scene& scene, const Tracer& tracer, const DirectOptions& options, bool lights_in_basis,
                 int light_samples, const MeshlessTuning& tuning, std::uint64_t seed, const Progress& progress,
                 Team team = {});

    const LightSampler& emitters() const { return emitters_; }
    const LightSampler& skies() const { return skies_; }
    const SurfelPoints& points() const { return points_; }

    // From lights and Environments.
    const Rgb& direct_at_surfel(std::size_t i) const { return direct_[i]; }
    // What of that, and of all, is beside the basis.
    Rgb direct_beside_basis(std::size_t i) const { return lights_in_basis_ ? Rgb{} : direct_at_surfel(i); }
    Rgb beside_basis(std::size_t i) const { return direct_beside_basis(i) + emitted_[i]; }
    // Standard error of the luminance of that, estimated (DirectOptions::dark_has_error); of emitters' it is not known.
    double error_beside_basis(std::size_t i) const {
        return lights_in_basis_ ? 0.0 : static_cast<double>(direct_error_[i]);
    }
    const Rgb& emitted_at_surfel(std::size_t i) const { return emitted_[i]; }
    bool lights_in_basis() const { return lights_in_basis_; }
    // Is there none beside the basis?
    bool is_dark() const { return beside().empty(); }

    // From lights and Environments, at places on surfaces.
    std::vector<Rgb> direct_at(const std::vector<Place>& places, const Progress& progress) const;

    // Rays that bring, in the mean, all of beside_basis() that there is at one point, but for what found() has: one
    // towards all lights (u choose it), where some would bring far more than others, whose light may be hidden, at
    // times some more (`random`).
    void towards(const Vec3& point, const Vec3& normal, const double (&u)[3], Random& random,
                 std::vector<LightRay>& out) const;
    // Of that, what a cosine-distributed ray from there finds; is there any?
    bool has_found() const { return !emitters_.empty() || beside().has_area_lights(); }
    Rgb found(const Ray& ray, const Hit& hit) const {
        const Departure& from = ray.from;
        return beside().found_on_way(from.position, from.normal, ray.direction, hit) +
               emitters_.found_at_end(from.normal, ray.direction, hit);
    }

private:
    struct Direct {
        Rgb irradiance;
        double error;  // standard error of the luminance, estimated
    };
    std::vector<Direct> estimate_direct(const std::vector<Place>& places, const Progress& progress) const;
    const LightSampler& beside() const { return lights_in_basis_ ? emitters_ : all_; }

    const Scene& scene_;
    const Tracer& tracer_;
    DirectOptions options_;
    bool lights_in_basis_;
    int light_samples_;
    double alike_, roulette_;  // MeshlessTuning::alike_lights, weaker_lights
    std::uint64_t seed_;
    Team team_;
    SurfelPoints points_;
    LightSampler all_, emitters_, skies_;
    SkyCells sky_cells_;
    std::vector<Rgb> direct_, emitted_;  // of surfels
    std::vector<float> direct_error_;
};

}  // namespace surflux
