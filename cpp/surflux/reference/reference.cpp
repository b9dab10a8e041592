#include "surflux/reference/reference.h"

#include "surflux/core/error.h"
#include "surflux/reference/path_tracer.h"
#include "surflux/trace/onto_surface.h"

namespace surflux {

namespace {

// A place that receives light and sends it on evenly: what a path carries is irradiance.
struct DiffuseVertex {
    LightRay light(const LightSampler& lights, const Departure& at, double u, double v, double choice,
                   int group) const {
        return lights.sample(at.position, at.normal, u, v, choice, group);
    }
    bool onward(const Departure& at, double u, double v, Random&, Vec3& direction, Rgb&) const {
        direction = frame_around(at.normal).to_world(square_to_cosine_hemisphere(u, v));
        return true;
    }
    Rgb found(const LightSampler& lights, const Ray& ray, const Hit& hit) const {
        return lights.found(ray.from.position, ray.from.normal, ray.direction, hit);
    }
    Rgb advance(const Surfels& surfels, const Ray&, const Hit& hit, const Rgb&, Rgb& throughput) const {
        return throughput = throughput * surfels.reflectance[hit.surfel];
    }
};

}  // namespace

Reference reference_irradiance(const CompiledScene& compiled, const std::vector<Vec3>& points,
                               const std::vector<Vec3>& normals, const ReferenceOptions& options,
                               const Progress& progress) {
    require(points.size() == normals.size(), "normals: wanted one for each of the ", points.size(), " points, got ",
            normals.size());
    const PathTracer<DiffuseVertex> paths(compiled, options, progress);
    const std::vector<Departure> places = departures(compiled, points, normals);
    return means_of_paths(
        paths, places, options.samples, [](std::size_t) { return DiffuseVertex{}; }, progress, options.team);
}

std::vector<Departure> departures(const CompiledScene& scene, const std::vector<Vec3>& points,
                                  const std::vector<Vec3>& normals) {
    const Tracer& tracer = scene.tracer();
    const std::vector<Vec3> on_surface = onto_surface(scene.scene().surfels, tracer, points, normals, by_rounding);
    std::vector<Departure> places(points.size());
    parallel_for(points.size(), 256, [&](std::size_t i) { places[i] = tracer.departure(on_surface[i], normals[i]); });
    return places;
}

}  // namespace surflux
