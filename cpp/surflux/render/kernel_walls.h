#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Where a wall stands on the plane of a kernel: from one end to the other, in the axes of the kernel from its centre.
struct WallTrace {
    std::array<float, 4> ends;  // x, y of one and of the other
};

// A kernel blends where its centre sees along the surface, not behind a wall that stands on it: a floor goes on beneath
// a wall, and its light does not. What no centre sees, as between the folds of a curtain, is blended of all (weights of
// 1e-6 are left behind walls). Walls are triangles that stand by 60 degrees or more on the plane of the kernel, or
// by 30 and face away from it, as the inside of a tent: with what is flatter, as in a bowl, the light blends. Nor does
// it blend with another sheet that stands off its plane farther than what it is joined to does.
class KernelWalls {
public:
    // Of kernels of `footprint` times what surfels reach (reach.h).
    KernelWalls(const Surfels& surfels, double footprint, const Progress& progress = {});

    // Of surfel i, by the axes of frame_around(normal).
    std::pair<const WallTrace*, const WallTrace*> of(std::size_t i) const {
        return {walls_.data() + begin_[i], walls_.data() + begin_[i + 1]};
    }
    // How far off the plane of surfel i lies what is joined to it (joined_depth.h).
    double depth(std::size_t i) const { return static_cast<double>(depth_[i]); }
    std::size_t size() const { return walls_.size(); }
    std::size_t surfels() const { return begin_.size() - 1; }

private:
    std::vector<std::uint32_t> begin_;
    std::vector<WallTrace> walls_;
    std::vector<float> depth_;
};

// Is (x, y) behind one of the walls [begin, end), seen from the centre? As kernel_fragment has it.
inline bool is_behind(const WallTrace* begin, const WallTrace* end, float x, float y) {
    for (const WallTrace* wall = begin; wall != end; ++wall) {
        const auto [ax, ay, bx, by] = wall->ends;
        const float center = ax * by - ay * bx, place = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
        const float left = x * ay - y * ax, right = x * by - y * bx;
        if (center * place < 0.0f && left * right < 0.0f) return true;
    }
    return false;
}

}  // namespace surflux
