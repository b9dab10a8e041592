#include "surflux/solution/self_check.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t check_stream = 0x5e1fc8ec;

}  // namespace

double gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                       std::uint64_t seed) {
    const Surfels& s = scene.surfels;
    const SurfelPoints points(s);
    const std::size_t checked = std::min<std::size_t>(static_cast<std::size_t>(surfels), s.size());
    std::vector<double> squared(checked), reference(checked);
    parallel_for(checked, 4, [&](std::size_t k) {
        const auto i =
            static_cast<std::uint32_t>(checked == s.size() ? k : Random(seed + check_stream, k).below(s.size()));
        const Frame frame = frame_around(s.normals[i]);
        const auto difference = [&](std::uint64_t half) {
            EvenPoints even(4, seed + check_stream + 1 + half, k);
            Rgb gathered;
            for (int r = 0; r < rays; ++r) {
                const double* u = even.next();
                const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
                const Hit hit = tracer.closest(i, points.at(i, u[2], u[3]), direction);
                if (hit && hit.front) gathered += solution.radiosity[hit.surfel];
            }
            return solution.direct[i] + gathered / rays - solution.irradiance[i];
        };
        squared[k] = s.areas[i] * dot(difference(0), difference(1));
        reference[k] = s.areas[i] * dot(solution.irradiance[i], solution.irradiance[i]);
    });
    double off = 0.0, all = 0.0, spread = 0.0;
    for (std::size_t k = 0; k < checked; ++k) off += squared[k], all += reference[k], spread += squared[k] * squared[k];
    // Below the standard error of the sum nothing is known: that is the least it claims.
    return all > 0.0 ? std::sqrt(std::max(off, std::sqrt(spread)) / all) : 0.0;
}

}  // namespace surflux
