#include "surflux/solution/final_gather.h"

#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

FinalGather::FinalGather(const Scene& scene, const Tracer& tracer, const Sight& sight, const NodalField& nodes,
                         const std::vector<double>& light, const std::vector<NodalField::Values>& fields, bool reflects)
    : scene_(scene),
      tracer_(tracer),
      sight_(sight),
      nodes_(nodes),
      light_(light),
      fields_(fields),
      reflects_(reflects) {}

Rgb FinalGather::sent(std::uint32_t surfel, const Vec3& at) const {
    const Surfels& s = scene_.surfels;
    const Rgb &rho = s.reflectance[surfel], &emission = s.emission[surfel];
    if (!reflects_ || rho == Rgb{}) return emission;
    thread_local std::vector<Interpolation::Weight> near;
    const Vec3& normal = s.normals[surfel];
    nodes_.interpolation().at(at, normal, scene_.object[surfel], near);
    if (!sight_.keep_joined(at, normal, nodes_.sites(), light_, near)) return emission;
    Rgb irradiance;
    for (const NodalField::Values& field : fields_) irradiance += nodes_.at(field, at, normal, near);
    return emission + rho * irradiance;
}

Rgb FinalGather::operator()(const Departure& place, int rays, std::uint64_t seed) const {
    const Frame frame = frame_around(place.normal);
    EvenPoints even(2, seed, stream_of({place.position, place.normal, place.surfel, Place::point}));
    std::vector<Ray> shot;
    std::vector<Hit> hits;
    for (int r = 0; r < rays; ++r) {
        const double* u = even.next();
        shot.push_back({place, frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    }
    tracer_.closest(shot, hits);
    Rgb sum;
    for (std::size_t r = 0; r < shot.size(); ++r)
        if (hits[r].front) sum += sent(hits[r].surfel, place.position + hits[r].distance * shot[r].direction);
    return sum / rays;
}

}  // namespace surflux
