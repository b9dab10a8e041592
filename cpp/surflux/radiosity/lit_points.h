#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sky_cells.h"
#include "surflux/lights/sky_irradiance.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance of the points of a tree that needs no solving: from lights, from images of the sky (sky_irradiance), and
// by next event estimation towards small emissive surfels (LightSampler). By point; those that were split have what
// they had.
class LitPoints {
public:
    // Without sampler and sky, of lights alone. Emitters get a quarter of `light_samples`, and all where some are
    // blocked, and as many cosine-distributed rays, too: both parts of their MIS estimate are had here, and none of
    // that steep light has to be interpolated. Half of `light_samples` go to the sky, and more behind openings.
    LitPoints(const Scene& scene, const SurfelPoints& surfels, const Tracer& tracer, const SurfelTree& tree,
              const LightSampler* emitters, const SkyCells* sky, const DirectOptions& options, int light_samples,
              std::uint64_t seed, Team team = {});

    // Lights up what the tree has more since the last time.
    void update(const Progress& progress = {});

    Rgb operator[](std::size_t p) const { return from_lights(p) + from_emitters(p); }
    Rgb from_emitters(std::size_t p) const { return emitters_.empty() ? Rgb{} : emitters_[p]; }
    // The same of points; nothing where there are no emitters.
    std::vector<Rgb> from_emitters(const std::vector<std::uint32_t>& points) const;
    // From what makes a Solution's direct light.
    Rgb from_lights(std::size_t p) const { return sky_.empty() ? lights_[p] : lights_[p] + sky_[p]; }
    // Estimated standard error of each, of its luminance.
    double standard_error(std::size_t p) const { return static_cast<double>(standard_error_[p]); }
    // Gives back what nobody asks for any more.
    void drop_errors() { std::vector<float>().swap(standard_error_); }
    bool is_grey() const;

    static Place place(const SurfelTree& tree, std::uint32_t point) {
        return {tree.position(point), tree.normal(point), tree.surfel(point),
                tree.is_inserted(point) ? Place::point : point};
    }

private:
    // Of some points; those of emitters and skies are empty where there are none.
    struct Light {
        std::vector<Rgb> lights, emitters;
        std::vector<float> errors;  // standard errors of the luminance of `lights`
        std::vector<SkyLight> sky;
        template <class Visit>
        void for_each(const Visit& visit) {
            visit(lights), visit(emitters), visit(errors), visit(sky);
        }
    };
    Light shine(const SurfelPoints& points, const std::vector<Place>& places, const Progress& progress) const;
    // The same, of which each process of the team makes a part.
    Light shine_together(const SurfelPoints& points, const std::vector<Place>& places, const Progress& progress) const;
    void refine_sky(const SurfelPoints& points, const std::vector<Place>& places, Light& found,
                    const Progress& progress) const;
    // Parts are small, and there are four of them.
    int each(int rays) const { return lights_.empty() ? rays : std::max(1, rays / 2); }
    int sky_rays() const { return each(light_samples_ / 2); }
    bool has_emitters() const { return sampled_emitters_ && !sampled_emitters_->empty(); }
    bool has_sky() const { return cells_ && !cells_->empty(); }

    const Scene& scene_;
    const SurfelPoints& surfels_;
    const Tracer& tracer_;
    const SurfelTree& tree_;
    const LightSampler* sampled_emitters_;
    const SkyCells* cells_;
    DirectOptions options_;
    int light_samples_;
    std::uint64_t seed_;
    Team team_;
    std::vector<Rgb> lights_, emitters_, sky_;  // the last two empty where there are none
    std::vector<float> standard_error_;
};

}  // namespace surflux
