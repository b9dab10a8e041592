#include "surflux/meshless/meshless_field.h"

#include <algorithm>

namespace surflux {

MeshlessField::At MeshlessField::at(const Vec3& point, const Vec3& normal, std::uint32_t object) const {
    At sum;
    basis.for_functions(point, normal, object, [&](const BasisWeight& w) {
        sum.all += w.weight * coefficients[w.function];
        sum.direct += w.weight * direct[w.function];
    });
    for (int c = 0; c < 3; ++c) {
        sum.all[c] = std::max(0.0, sum.all[c]);
        sum.direct[c] = std::clamp(sum.direct[c], 0.0, sum.all[c]);
    }
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
