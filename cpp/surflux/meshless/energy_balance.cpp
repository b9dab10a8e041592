#include "surflux/meshless/energy_balance.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

double energy_correction(const Scene& scene, const SurfaceLight& light, const SurfelMeans& means,
                         const std::vector<Rgb>& coefficients, const std::vector<Rgb>& bounced,
                         const std::vector<Rgb>& lost, bool indirect_only) {
    const Surfels& s = scene.surfels;
    const auto sum = [](const Rgb& c) { return c.x + c.y + c.z; };
    struct Flux {
        double sent = 0.0, kept = 0.0, received = 0.0;  // kept: less what is lost
        void operator+=(const Flux& other) { sent += other.sent, kept += other.kept, received += other.received; }
    };
    const Flux flux = parallel_sum<Flux>(s.size(), 256, [&](std::size_t i, Flux& to) {
        if (means.outside(i) == 0.0) return;
        Rgb all = indirect_only ? light.at_surfel(i) : Rgb{}, arrived;
        double away = 0.0;
        means.for_functions(i, [&](std::uint32_t j, double weight) {
            all += weight * coefficients[j];
            arrived += weight * bounced[j];
            away += weight * lost[j].x;
        });
        const double sent = s.areas[i] * sum(s.reflectance[i] * all);
        to.sent += sent;
        to.kept += (1.0 - std::clamp(away, 0.0, 1.0)) * sent;
        to.received += s.areas[i] * sum(arrived);
    });
    if (!(flux.received > 0.0) || !(flux.kept > 0.0)) return 1.0;
    // Where most is lost, what is kept is a small difference, and no measure.
    return std::pow(flux.kept / flux.received, flux.kept / flux.sent);
}

}  // namespace surflux
