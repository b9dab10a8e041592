#include "surflux/solution/power_balance.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

constexpr double significance = 2.0;  // standard errors within which own rays may be off

double sum(const Rgb& c) { return c.x + c.y + c.z; }

}  // namespace

void PowerBalance::add(std::uint32_t part, const Surfel& s) {
    if (part >= parts_.size()) parts_.resize(part + 1);
    Flux& flux = parts_[part];
    flux.entered += s.area * sum(s.direct + s.emission);
    flux.absorbed += s.area * sum((Rgb{1, 1, 1} - s.reflectance) * s.irradiance);
    const double reflected = s.area * sum(s.reflectance * s.irradiance), emitted = s.area * sum(s.emission);
    flux.escaped += s.lost_scale * s.loss.escape * reflected;
    flux.into_backs += s.lost_scale * s.loss.into_backs * reflected;
    if (!emission_sampled_) {
        flux.escaped += s.lost_scale * s.loss.escape * emitted;
        flux.into_backs += s.lost_scale * s.loss.into_backs * emitted;
        return;
    }
    flux.emitted += emitted;
    flux.arrived += s.area * s.from_emitters;
    flux.emission_escaped += s.loss.escape * emitted;
    flux.emission_into_backs += s.loss.into_backs * emitted;
    flux.doubt += s.loss.doubt * emitted;
    flux.variance += s.loss.variance * emitted * sum(s.emission);
}

void PowerBalance::Flux::operator+=(const Flux& other) {
    entered += other.entered, absorbed += other.absorbed;
    escaped += other.escaped, into_backs += other.into_backs;
    emitted += other.emitted, arrived += other.arrived;
    emission_escaped += other.emission_escaped, emission_into_backs += other.emission_into_backs;
    doubt += other.doubt, variance += other.variance;
}

void PowerBalance::operator+=(const PowerBalance& other) {
    if (other.parts_.size() > parts_.size()) parts_.resize(other.parts_.size());
    for (std::size_t part = 0; part < other.parts_.size(); ++part) parts_[part] += other.parts_[part];
}

void PowerBalance::Flux::settle_emission() {
    const double lost_by_rays = emission_escaped + emission_into_backs;
    if (!(lost_by_rays > 0.0)) return;
    const double noise = significance * (std::sqrt(variance) + doubt);
    const double lost_of_emission = std::clamp(emitted - arrived, lost_by_rays - noise, lost_by_rays + noise);
    const double scale = std::max(0.0, lost_of_emission) / lost_by_rays;
    escaped += scale * emission_escaped;
    into_backs += scale * emission_into_backs;
}

Figures PowerBalance::figures() const {
    double entered = 0.0, absorbed = 0.0, escaped = 0.0, into_backs = 0.0, worst = 0.0;
    for (Flux part : parts_) {
        part.settle_emission();
        entered += part.entered;
        absorbed += part.absorbed;
        escaped += part.escaped;
        into_backs += part.into_backs;
        if (part.entered > 0.0) worst = std::max(worst, std::abs(part.lost()) / part.entered);
    }
    return {{"power_in", entered},
            {"power_absorbed", absorbed},
            {"power_escaped", escaped},
            {"power_into_backs", into_backs},
            {"power_lost", entered - absorbed - escaped - into_backs},
            {"parts", static_cast<double>(parts_.size())},
            {"largest_part_lost", worst}};
}

}  // namespace surflux
