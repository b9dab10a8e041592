#include "surflux/solution/power_balance.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

double sum(const Rgb& c) { return c.x + c.y + c.z; }

}  // namespace

void PowerBalance::Flux::operator+=(const Flux& other) {
    entered += other.entered;
    absorbed += other.absorbed;
    escaped += other.escaped;
    into_backs += other.into_backs;
}

void PowerBalance::add(std::uint32_t part, const Surfel& s) {
    if (part >= parts_.size()) parts_.resize(part + 1);
    const double sent = s.area * sum(s.emission + s.reflectance * s.irradiance);
    parts_[part] += {s.area * sum(s.direct + s.emission), s.area * sum((Rgb{1, 1, 1} - s.reflectance) * s.irradiance),
                     s.escape * sent, s.into_backs * sent};
}

Figures PowerBalance::figures() const {
    Flux all;
    double worst = 0.0;
    for (const Flux& part : parts_) {
        all += part;
        if (part.entered > 0.0) worst = std::max(worst, std::abs(part.lost()) / part.entered);
    }
    return {{"power_in", all.entered},      {"power_absorbed", all.absorbed},
            {"power_escaped", all.escaped}, {"power_into_backs", all.into_backs},
            {"power_lost", all.lost()},     {"parts", static_cast<double>(parts_.size())},
            {"largest_part_lost", worst}};
}

}  // namespace surflux
