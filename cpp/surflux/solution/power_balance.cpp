#include "surflux/solution/power_balance.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

double sum(const Rgb& c) { return c.x + c.y + c.z; }

}  // namespace

void PowerBalance::add(std::uint32_t part, const Surfel& s) {
    if (part >= parts_.size()) parts_.resize(part + 1);
    Flux& flux = parts_[part];
    const Rgb radiosity = s.emission + s.reflectance * s.irradiance;
    flux.entered += s.area * (s.direct + s.emission);
    flux.absorbed += s.area * ((Rgb{1, 1, 1} - s.reflectance) * s.irradiance);
    flux.escaped += (s.area * s.loss.escape) * radiosity;
    flux.into_backs += (s.area * s.loss.into_backs) * radiosity;
    flux.variance += s.loss.variance * s.area * sum(radiosity) * sum(radiosity);
}

void PowerBalance::Flux::operator+=(const Flux& other) {
    entered += other.entered, absorbed += other.absorbed;
    escaped += other.escaped, into_backs += other.into_backs;
    variance += other.variance;
}

void PowerBalance::operator+=(const PowerBalance& other) {
    if (other.parts_.size() > parts_.size()) parts_.resize(other.parts_.size());
    for (std::size_t part = 0; part < other.parts_.size(); ++part) parts_[part] += other.parts_[part];
}

Figures PowerBalance::figures() const {
    Flux all;
    double worst = 0.0;
    for (const Flux& part : parts_) all += part;
    for (const Flux& part : parts_)
        for (int c = 0; c < 3; ++c) {
            // A dark part is held against all that enters the scene.
            const double entered = part.entered[c] > 0.0 ? part.entered[c] : all.entered[c];
            if (entered > 0.0) worst = std::max(worst, std::abs(part.lost()[c]) / entered);
        }
    return {{"power_in", sum(all.entered)},
            {"power_absorbed", sum(all.absorbed)},
            {"power_escaped", sum(all.escaped)},
            {"power_into_backs", sum(all.into_backs)},
            {"power_lost", sum(all.lost())},
            {"power_lost_error", std::sqrt(all.variance)},
            {"parts", static_cast<double>(parts_.size())},
            {"largest_part_lost", worst}};
}

}  // namespace surflux
