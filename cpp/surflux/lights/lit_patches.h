#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Importance sampling of the first bounce: patches that lights shine on, as many lights, by clusters alike in position
// and normal (Conty Estevez and Kulla 2018) in proportion to their unoccluded irradiance at a place, and within a
// cluster by power. For multiple importance sampling with cosine-distributed rays, which rarely meet a spot of sun.
// They are taken to be flat.
class LitPatches {
public:
    // `exitance`: what each surfel sends of that light, by area. Disks are not drawn: which part of one is surface,
    // only a ray can tell.
    LitPatches(const Surfels& surfels, const SurfelPoints& points, const std::vector<double>& exitance);

    // Of all that surfels send, what these do; 0 where there are none.
    double share() const { return share_; }

    // Cumulative distribution over groups, by the irradiance each may bring to a place; not normalized.
    using Aim = std::vector<float>;
    // Fills it in for a place; false where none brings anything.
    bool aim(const Vec3& point, const Vec3& normal, Aim& out) const;

    struct Target {
        Vec3 point;
        std::uint32_t surfel;
    };
    // (u, v) choose the place on the patch, `choice` the patch; all in [0, 1).
    Target sample(const Aim& aim, double choice, double u, double v) const;
    // Density per unit of area with which sample() draws points of a surfel, for MIS weights. Only where aim() said
    // true.
    double density(const Aim& aim, std::uint32_t surfel) const;

private:
    struct Group;
    std::vector<Group> split(const Surfels& surfels, const std::vector<double>& power);
    void add(const Surfels& surfels, const std::vector<double>& power, const Group& group);

    const SurfelPoints& points_;
    double share_ = 0.0;
    std::vector<std::uint32_t> patches_;  // by group
    std::vector<double> up_to_;           // share of the power, of each of patches_ and those before it in its group
    std::vector<std::uint32_t> begin_;    // of groups in patches_, and one more
    std::vector<std::uint32_t> group_;    // of each surfel, or none
    std::vector<double> exitance_;        // of each surfel, over the power of all patches
    // Coordinates below, which are floats: from here, in this unit.
    Vec3 origin_;
    double unit_ = 1.0;
    std::vector<float> power_, x_, y_, z_, normal_x_, normal_y_, normal_z_, radius_, normal_spread_;  // of each group
};

}  // namespace surflux
