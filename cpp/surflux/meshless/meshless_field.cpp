#include "surflux/meshless/meshless_field.h"

#include <algorithm>

namespace surflux {

void MeshlessField::At::clamp() {
    for (int c = 0; c < 3; ++c) {
        all[c] = std::max(0.0, all[c]);
        direct[c] = std::clamp(direct[c], 0.0, all[c]);
    }
}

MeshlessField::At MeshlessField::at(const Vec3& point, const Vec3& normal, std::uint32_t object) const {
    At sum;
    basis.for_functions(point, normal, object, [&](const BasisWeight& w) {
        sum.all += w.weight * coefficients[w.function];
        sum.direct += w.weight * direct[w.function];
    });
    sum.clamp();
    return sum;
}

std::int32_t MeshlessField::level_at(const Vec3& point, const Vec3& normal, std::uint32_t object) const {
    std::int32_t finest = 0;
    basis.for_functions(point, normal, object, [&](const BasisWeight& w) {
        if (gathered[w.function]) finest = std::max(finest, static_cast<std::int32_t>(basis.level_of(w.function)));
    });
    return finest;
}

}  // namespace surflux
