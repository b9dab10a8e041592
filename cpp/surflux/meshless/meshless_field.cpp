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

}  // namespace surflux
