#include "surflux/solution/final_gather.h"

#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

FinalGather::FinalGather(const Scene& scene, const Tracer& tracer, const Sight& sight, const NodalField& nodes,
                         const std::vector<Rgb>& light, const std::vector<NodalField::Values>& fields)
    : scene_(scene),
      tracer_(tracer),
      sight_(sight),
      nodes_(nodes),
      light_(light),
      fields_(fields),
      emitters_(LightSampler::of_surfels(scene)) {}

Rgb FinalGather::reflected(std::uint32_t surfel, const Vec3& at) const {
    const Surfels& s = scene_.surfels;
    const Rgb& rho = s.reflectance[surfel];
    if (rho == Rgb{}) return {};
    thread_local std::vector<Interpolation::Weight> near;
    const Vec3& normal = s.normals[surfel];
    nodes_.interpolation().at(at, normal, scene_.object[surfel], near);
    if (!sight_.keep_joined(at, normal, nodes_.sites(), light_, near)) return {};
    Rgb irradiance;
    for (const NodalField::Values& field : fields_) irradiance += nodes_.at(field, at, normal, near);
    return rho * irradiance;
}

Rgb FinalGather::operator()(const Departure& departure, int rays, std::uint64_t seed, float* on_backs) const {
    const Place place{departure.position, departure.normal, departure.surfel, Place::point};
    const Frame frame = frame_around(place.normal);
    EvenPoints even(2, seed, stream_of(place));
    std::vector<Ray> shot;
    std::vector<Hit> hits;
    for (int r = 0; r < rays; ++r) {
        const double* u = even.next();
        shot.push_back({departure, frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    }
    tracer_.closest(shot, hits);
    Rgb sum;
    int backs = 0;
    for (std::size_t r = 0; r < shot.size(); ++r) {
        if (!hits[r].front) {
            backs += hits[r] ? 1 : 0;
            continue;
        }
        sum += reflected(hits[r].surfel, place.position + hits[r].distance * shot[r].direction);
        if (!emitters_.samples(hits[r].surfel)) sum += scene_.surfels.emission[hits[r].surfel];
    }
    if (on_backs) *on_backs = static_cast<float>(backs) / static_cast<float>(rays);
    return sum / rays;
}

}  // namespace surflux
