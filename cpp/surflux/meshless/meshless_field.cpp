#include "surflux/meshless/meshless_field.h"

#include <algorithm>

#include "surflux/meshless/level_light.h"

namespace surflux {

void MeshlessField::At::clamp() {
    for (int c = 0; c < 3; ++c) {
        all[c] = std::max(0.0, all[c]);
        direct[c] = std::clamp(direct[c], 0.0, all[c]);
    }
}

MeshlessField::At MeshlessField::at(const Vec3& point, const Vec3& normal, std::uint32_t object) const {
    thread_local std::vector<BasisWeight> weights;
    At out;
    for (std::size_t level = 0; level < basis.levels(); ++level) {
        basis.at_level(level, point, normal, object, weights);
        LevelLight(*this, weights).add_to(out);
    }
    out.clamp();
    return out;
}

bool MeshlessField::at(const Vec3& point, const Vec3& normal, std::uint32_t object, const BasisSight& sight,
                       At& out) const {
    thread_local std::vector<BasisWeight> weights;
    out = {};
    for (std::size_t level = 0; level < basis.levels(); ++level) {
        sight.at_level(level, point, normal, object, Hit::none, weights);
        if (weights.empty() && basis.is_coarsest(level, object)) return false;
        LevelLight(*this, weights).add_to(out);
    }
    out.clamp();
    return true;
}

std::int32_t MeshlessField::level_at(const Vec3& point, const Vec3& normal, std::uint32_t object) const {
    std::int32_t finest = 0;
    basis.for_functions(point, normal, object, [&](const BasisWeight& w) {
        if (gathered[w.function]) finest = std::max(finest, static_cast<std::int32_t>(basis.level_of(w.function)));
    });
    return finest;
}

}  // namespace surflux
