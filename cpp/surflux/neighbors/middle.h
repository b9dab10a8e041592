#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Where most points are: the median along each axis of about `looked_at` of them. The centre of the bounding box would
// be where one outlier puts it.
inline Vec3 middle_of(const std::vector<Vec3>& points, std::size_t looked_at) {
    const std::size_t step = points.size() / looked_at + 1;
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (std::size_t k = 0; k < points.size(); k += step) values.push_back(points[k][axis]);
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        out[axis] = *middle;
    }
    return out;
}

}  // namespace surflux
