#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// A frame of a depth camera at the origin, which looks along z or back, without the steps of its depth. Such cameras
// measure a disparity, 1 / |z|, in whole multiples of `step`, and are off by a step or two besides. The disparity of a
// plane is linear over the picture, x / z and y / z, however it lies: it is fitted over windows of pixels, of what
// follows it, that grow as long as it fits. Pixels move by 1.5 steps at most, and to a plane that most around them are
// of by 6; where they are off planes by more than half a step, by so much more.
struct SmoothedDepth {
    std::vector<Vec3> points;  // moved along their rays
    std::vector<char> is_off;  // those that hardly any pixel around is about as far as
};
SmoothedDepth without_depth_steps(const std::vector<Vec3>& points, double step, const Progress& progress = {});

}  // namespace surflux
