#include "surflux/lights/hemisphere_row.h"

#include "surflux/core/sampling.h"

namespace surflux {

void gather_row(const SurfelPoints& points, const Tracer& tracer, const Place& place, int count, std::uint64_t seed,
                HemisphereRow& out) {
    const Frame frame = frame_around(place.normal);
    EvenPoints even(points.extends(place) ? 4 : 2, seed, stream_of(place));
    out.rays.clear();
    for (int k = 0; k < count; ++k) {
        const double* u = even.next();
        out.rays.push_back({{points.at(place, u[2], u[3]), place.normal, place.surfel},
                            frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    }
    tracer.closest(out.rays, out.hits);
}

}  // namespace surflux
