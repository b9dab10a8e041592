#include "surflux/radiosity/normal_field.h"

#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/solution/slope_fit.h"

namespace surflux {

NormalField::NormalField(std::vector<Vec3> positions, std::vector<Vec3> normals, std::vector<std::uint32_t> objects,
                         const RefinementTuning& tuning)
    : positions_(std::move(positions)),
      normals_(std::move(normals)),
      objects_(std::move(objects)),
      interpolation_(positions_, normals_, objects_),
      slopes_(positions_.size()),
      most_turn_(tuning.most_normal_turn) {
    const std::size_t around = whole_number(tuning.normals_around);
    const double stiffness = tuning.normal_stiffness;
    parallel_blocks(positions_.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<Interpolation::Weight> near;
        for (std::size_t i = begin; i < end; ++i) {
            interpolation_.nearest(positions_[i], normals_[i], objects_[i], around, near);
            const Frame frame = frame_around(normals_[i]);
            SlopeFit<Vec3> fit(stiffness);
            for (const Interpolation::Weight& other : near) {
                const Vec3 d = positions_[other.site] - positions_[i];
                if (other.site != i && length_squared(d) > 0.0)
                    fit.add(dot(d, frame.u), dot(d, frame.v), 1.0 / length_squared(d),
                            normals_[other.site] - normals_[i]);
            }
            fit.solve(slopes_[i].u, slopes_[i].v);  // else it stays 0
        }
    });
}

Vec3 NormalField::at(const Vec3& point, const Vec3& facing, std::uint32_t object) const {
    thread_local std::vector<Interpolation::Weight> near;
    interpolation_.at(point, facing, object, near);
    Vec3 mean, sloped;
    for (const Interpolation::Weight& w : near) {
        const Frame frame = frame_around(normals_[w.site]);
        const Vec3 d = point - positions_[w.site];
        mean += w.weight * normals_[w.site];
        sloped +=
            w.weight * (normals_[w.site] + dot(d, frame.u) * slopes_[w.site].u + dot(d, frame.v) * slopes_[w.site].v);
    }
    // Where it would turn farther than neighbours may differ, they are not of one smooth surface.
    for (const Vec3& n : {sloped, mean})
        if (dot(n, facing) > most_turn_ * length(n)) return normalized(n);
    return facing;
}

}  // namespace surflux
