#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "surflux/lights/emissive_facets.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/glossy_lobe.h"
#include "surflux/lights/photometric_web.h"
#include "surflux/lights/spot_cone.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Of light that may be below 0, as skies made of some harmonics are, by its size.
inline double brightness(const Rgb& c) { return std::abs(c.x) + std::abs(c.y) + std::abs(c.z); }

// A light sample: the irradiance that its shadow ray brings to a point, if that is unoccluded, or meets the front of
// `target` first where there is one: LightRays (light_rays.h) tells.
struct LightRay {
    Vec3 direction;
    double length = 0.0;
    Rgb irradiance;
    std::uint32_t target = Hit::none;
    bool is_of_lamp = false;  // neither of the sky nor of a surfel
    double density = 0.0;     // of the direction, per steradian, as its MIS weight has it; 0 of lights without extent
};

// Next event estimation with multiple importance sampling: light samples towards lights, images of the sky and emissive
// surfels, by sample(), and what a cosine-distributed ray meets of them, by found(). Each is weighted by the balance
// heuristic (Veach and Guibas 1995), so that both together give the irradiance once.
class LightSampler {
public:
    // With `whole_images` light samples alone have all that images of the sky bring, and found() has nothing of them.
    enum class Sources { all, whole_images, surfels, constant_sky };
    // Emissive surfels are sampled if they cover at most this share of the surface of the scene; else those alone that
    // shine several times as strongly as the mean of them, as a heater in a room whose walls glow. What is larger
    // cosine-distributed rays find as well. Measured on a sphere in a sphere and a lamp in a room: a gain of 2 at 0.1,
    // of 30 at 0.04, and none from 0.2 on.
    static constexpr double usual_small_emitters = 0.15;
    // Points of emissive patches, of each cluster its part, drawn by power, of which a light sample takes one by what
    // it would bring (resampled importance sampling, Talbot et al. 2005): the more, the less it matters how many
    // emitters there are, how far, and which way they face. With 8 light under a ball, or of nine or 36 lamps in a
    // room, is off by a fifth to a quarter of what it is off by with 1, for a tenth to two fifths more time; 16 take as
    // much more again, and find less where walls stand between lamps. Of disks, which overlap, few light samples meet
    // their own first: there is one, so that hemisphere samples have the more weight.
    static constexpr int usual_candidates = 8;
    explicit LightSampler(const Scene& scene, double small_emitters = usual_small_emitters,
                          Sources sources = Sources::all);

    // Of emissive surfels alone.
    static LightSampler of_surfels(const Scene& scene);

    bool empty() const { return point_like_.empty() && areas_.empty() && images_.empty() && emitters_.empty(); }
    // Is it among the emissive surfels that are sampled?
    bool samples(std::uint32_t surfel) const { return !sampled_.empty() && sampled_[surfel]; }
    // Are there lights on the way of rays, which found_on_way() finds?
    bool has_area_lights() const { return !areas_.empty(); }
    // Radiance of the sky that is alike all around.
    const Rgb& constant_sky() const { return constant_sky_; }
    // Lights are in so many groups, most in one of their own: what a strong one would bring, but for a wall, leaves
    // few light samples to a weak one nearby where both are drawn together.
    static constexpr int most_groups = 8;
    int groups() const { return groups_; }
    // One light sample for all lights of a group, or of all of them: of candidates towards each, resampled in
    // proportion to what it would bring. (u, v) choose the place on each light, `choice` the light; all in [0, 1).
    static constexpr int all_groups = -1;
    LightRay sample(const Vec3& point, const Vec3& normal, double u, double v, double choice,
                    int group = all_groups) const;
    // The same with what a glossy surface sends of the light instead of irradiance, of rays that it draws.
    LightRay sample(const Vec3& point, const GlossyLobe& lobe, double u, double v, double choice,
                    int group = all_groups) const;
    // What all lamps, which are no surfels, would bring if nothing stood between, in closed form.
    Rgb unoccluded(const Vec3& point, const Vec3& normal) const;
    // Emissive surfels in closed form, by group: of_surfels() has them, where all are patches and few edges tell them.
    const EmissiveFacets* facets() const { return facets_ ? &*facets_ : nullptr; }
    // What a ray drawn with density cos / pi finds of lights that sample() draws too, and of the constant sky, as
    // irradiance: pi times the radiance times its MIS weight. `hit` is what it meets first.
    Rgb found(const Vec3& point, const Vec3& normal, const Vec3& direction, const Hit& hit) const {
        return found_on_way(point, normal, direction, hit) + found_at_end(normal, direction, hit);
    }
    // What a glossy surface sends of what a ray finds that it drew.
    Rgb found(const Vec3& point, const GlossyLobe& lobe, const Vec3& direction, const Hit& hit) const;
    // Of area lights, which rays pass through, and of what a ray meets or finds beyond all; of surfels alone, those
    // that are sampled.
    Rgb found_on_way(const Vec3& point, const Vec3& normal, const Vec3& direction, const Hit& hit) const;
    Rgb found_at_end(const Vec3& normal, const Vec3& direction, const Hit& hit) const;

private:
    struct PointLike {
        enum Kind { point, spot, photometric, distant } kind;
        Vec3 place;  // or the direction to it
        Rgb color;
        SpotCone cone;
        std::size_t web = 0;  // of a photometric light, in webs_
        int group = 0;
    };
    struct Rectangle {
        Vec3 corner, u, v, normal;  // unit
        double area;
        Rgb exitance;
        int group = 0;
        // Does a point lie before it?
        bool lights(const Vec3& point) const;
    };
    // A disk (c unused: centre a, radius b.x) or a triangle that emits.
    struct Piece {
        std::uint32_t surfel;
        bool is_disk;
        Vec3 a, b, c, normal;
    };
    // Emissive surfels that are sampled together: those close to each other.
    struct Cluster {
        std::uint32_t begin, end;  // of emitters_
        double power = 0.0;
        int group = 0;
    };
    struct Emitting;
    void take_emitters(const std::vector<Emitting>& emitting);
    void number_groups();
    void find_facets();
    template <class Weigh>
    LightRay resampled(const Vec3& point, const Vec3& normal, double u, double v, double choice, int group,
                       const Weigh& weigh) const;
    // Sums of exitances times share(density at which light sampling draws the direction; 0 where it does not).
    template <class Share>
    Rgb shares_on_way(const Vec3& point, const Vec3& direction, const Hit& hit, const Share& share) const;
    template <class Share>
    Rgb shares_at_end(const Vec3& direction, const Hit& hit, const Share& share) const;
    LightRay towards(const PointLike& light, const Vec3& point, const Vec3& normal) const;
    LightRay towards(const Rectangle& light, const Vec3& point, const Vec3& normal, double u, double v) const;
    LightRay towards_sky(std::size_t image, const Vec3& normal, double u, double v) const;
    LightRay towards_emitters(const Cluster& cluster, int candidates, const Vec3& point, const Vec3& normal, double u,
                              double v) const;
    // Density, by area, at which a point of the surfel is drawn among those of its cluster.
    double emitter_density(std::uint32_t surfel) const;
    // Of direction, of all candidates that a group of its own has, for a ray of that length to the surfel. Weights of
    // multiple importance sampling go by it, however many there are.
    double emitter_density(std::uint32_t surfel, const Vec3& direction, double distance) const;

    const Surfels& surfels_;
    std::vector<PointLike> point_like_;
    std::vector<PhotometricWeb> webs_;
    std::vector<Rectangle> areas_;
    std::vector<EnvironmentMap> images_;
    bool whole_images_, surfels_alone_;
    Rgb constant_sky_;
    int candidates_ = usual_candidates;
    std::vector<Piece> emitters_;
    std::vector<char> sampled_;  // of surfels; empty: none
    std::vector<Cluster> clusters_;
    std::vector<std::uint8_t> cluster_of_;  // of surfels
    std::vector<int> image_groups_;
    int groups_ = 0;
    std::vector<double> emitters_up_to_;  // share of the power of their cluster up to and with each
    std::optional<EmissiveFacets> facets_;
};

}  // namespace surflux
