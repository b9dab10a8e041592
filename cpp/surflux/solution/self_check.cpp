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
        Random random(seed + check_stream, k);
        const auto i = static_cast<std::uint32_t>(checked == s.size() ? k : random.below(s.size()));
        const Frame frame = frame_around(s.normals[i]);
        Rgb sum, sum_of_squares;
        for (int r = 0; r < rays; ++r) {
            // Independent rays: their spread tells how much of the difference is theirs.
            const double u = random.uniform(), v = random.uniform(), a = random.uniform(), b = random.uniform();
            const Hit hit = tracer.closest(i, points.at(i, a, b), frame.to_world(square_to_cosine_hemisphere(u, v)));
            if (!hit || !hit.front) continue;
            const Rgb& arrived = solution.radiosity[hit.surfel];
            sum += arrived;
            sum_of_squares += arrived * arrived;
        }
        const Rgb mean = sum / rays;
        const Rgb variance = (sum_of_squares / rays - mean * mean) / (rays - 1);
        const Rgb off = solution.direct[i] + mean - solution.irradiance[i];
        squared[k] = s.areas[i] * (dot(off, off) - variance.x - variance.y - variance.z);
        reference[k] = s.areas[i] * dot(solution.irradiance[i], solution.irradiance[i]);
    });
    double off = 0.0, all = 0.0;
    for (std::size_t k = 0; k < checked; ++k) off += squared[k], all += reference[k];
    return all > 0.0 ? std::sqrt(std::max(0.0, off) / all) : 0.0;
}

}  // namespace surflux
