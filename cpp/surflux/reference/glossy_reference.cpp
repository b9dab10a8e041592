#include "surflux/reference/glossy_reference.h"

#include "surflux/core/error.h"
#include "surflux/reference/path_tracer.h"

namespace surflux {

namespace {

// A place as it is seen from one direction: what a path carries is radiance.
struct GlossyVertex {
    GlossyLobe lobe;
    bool glossy_bounces;

    LightRay light(const LightSampler& lights, const Departure& at, double u, double v, double choice,
                   int group) const {
        return lights.sample(at.position, lobe, u, v, choice, group);
    }
    bool onward(const Departure&, double u, double v, Random& random, Vec3& direction, Rgb& carried) const {
        direction = lobe.sample(u, v, random.uniform());
        const Rgb value = lobe.value(direction);  // nothing from below
        if (value == Rgb{}) return false;
        carried = value / lobe.density(direction);
        return true;
    }
    Rgb found(const LightSampler& lights, const Ray& ray, const Hit& hit) const {
        return lights.found(ray.from.position, lobe, ray.direction, hit);
    }
    Rgb advance(const Surfels& surfels, const Ray& ray, const Hit& hit, const Rgb& carried, Rgb& throughput) {
        const std::uint32_t i = hit.surfel;
        const Rgb specular = glossy_bounces ? surfels.gloss.specular(i) : Rgb{};
        lobe =
            GlossyLobe(surfels.normals[i], -ray.direction, surfels.reflectance[i], specular, surfels.gloss.exponent(i));
        throughput = throughput * carried;
        return throughput * (surfels.reflectance[i] + specular);
    }
};

}  // namespace

Reference reference_radiance(const CompiledScene& compiled, const GlossyPlaces& places, const GlossyOptions& options,
                             const Progress& progress) {
    const std::size_t n = places.points.size();
    require(places.normals.size() == n && places.directions.size() == n,
            "normals, directions: wanted one for each of the ", n, " points, got ", places.normals.size(), " and ",
            places.directions.size());
    const auto fits = [&](std::size_t size) { return size == 0 || size == n; };
    require(fits(places.reflectance.size()) && fits(places.specular.size()) && fits(places.exponents.size()),
            "materials: wanted one for each of the ", n, " points, or none");
    const PathTracer<GlossyVertex> paths(compiled, options, progress);
    const std::vector<Departure> from = departures(compiled, places.points, places.normals);
    const bool own = places.reflectance.empty() || places.specular.empty() || places.exponents.empty();
    for (std::size_t i = 0; i < n && own; ++i)
        require(from[i].surfel != Hit::none, "points: ", i,
                " lies on no surfel: give reflectance, specular and exponent of all");

    const Surfels& surfels = compiled.scene().surfels;
    const auto seen_from_front = [&](std::size_t i) { return dot(places.normals[i], places.directions[i]) > 0.0; };
    const auto vertex = [&](std::size_t i) {
        const std::uint32_t k = from[i].surfel;
        Rgb rho, specular;
        if (seen_from_front(i)) {
            rho = places.reflectance.empty() ? surfels.reflectance[k] : places.reflectance[i];
            specular = places.specular.empty() ? surfels.gloss.specular(k) : places.specular[i];
        }
        const double exponent = places.exponents.empty() ? surfels.gloss.exponent(k) : places.exponents[i];
        const GlossyLobe lobe(places.normals[i], places.directions[i], rho, specular, exponent);
        return GlossyVertex{lobe, options.glossy_bounces};
    };
    Reference out = means_of_paths(paths, from, options.samples, vertex, progress);
    for (std::size_t i = 0; i < n; ++i)
        if (from[i].surfel != Hit::none && seen_from_front(i))
            out.irradiance[i] += surfels.emission[from[i].surfel] / pi;
    return out;
}

}  // namespace surflux
