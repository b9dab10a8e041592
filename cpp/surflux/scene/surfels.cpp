#include "surflux/scene/surfels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

template <class T>
std::vector<std::uint32_t> ranges(const std::vector<T>& items, std::size_t surfels) {
    std::vector<std::uint32_t> begin(surfels + 1, 0);
    for (const T& item : items) ++begin[item.surfel + 1];
    for (std::size_t i = 0; i < surfels; ++i) begin[i + 1] += begin[i];
    return begin;
}

}  // namespace

std::vector<std::uint32_t> triangle_ranges(const Surfels& surfels) { return ranges(surfels.triangles, surfels.size()); }

std::vector<std::uint32_t> end_ranges(const Surfels& surfels) { return ranges(surfels.ends, surfels.size()); }

Surfels select(const Surfels& surfels, const std::vector<std::uint32_t>& indices, const Progress& progress) {
    const std::vector<std::uint32_t> begin = triangle_ranges(surfels), first_end = end_ranges(surfels);
    Surfels out;
    const auto take = [&](const auto& all, auto& taken) {
        if (all.empty()) return;
        taken.resize(indices.size());
        parallel_for(indices.size(), 4096, [&](std::size_t k) { taken[k] = all[indices[k]]; }, progress);
    };
    take(surfels.positions, out.positions);
    take(surfels.normals, out.normals);
    take(surfels.radii, out.radii);
    take(surfels.areas, out.areas);
    out.gloss = surfels.gloss.select(indices);
    out.reflectance.reserve(indices.size());
    out.emission.reserve(indices.size());
    for (std::size_t to = 0; to < indices.size(); ++to) {
        report_some(progress, to, indices.size(), 1 << 20);
        const std::uint32_t from = indices[to];
        out.reflectance.push_back(surfels.reflectance[from]);
        out.emission.push_back(surfels.emission[from]);
        for (std::uint32_t t = begin[from]; t < begin[from + 1]; ++t) {
            out.triangles.push_back(surfels.triangles[t]);
            out.triangles.back().surfel = static_cast<std::uint32_t>(to);
        }
        for (std::uint32_t e = first_end[from]; e < first_end[from + 1]; ++e) {
            out.ends.push_back(surfels.ends[e]);
            out.ends.back().surfel = static_cast<std::uint32_t>(to);
        }
        if (std::binary_search(surfels.alone.begin(), surfels.alone.end(), from))
            out.alone.push_back(static_cast<std::uint32_t>(to));
    }
    return out;
}

Surfels two_sided(const Surfels& surfels) {
    const std::size_t n = surfels.size();
    std::vector<std::uint32_t> twice(2 * n);
    for (std::size_t i = 0; i < 2 * n; ++i) twice[i] = static_cast<std::uint32_t>(i % n);
    Surfels out = select(surfels, twice);
    for (std::size_t i = n; i < 2 * n; ++i) out.normals[i] = -out.normals[i];
    for (Triangle& t : out.triangles)
        if (t.surfel >= n) std::swap(t.b, t.c);
    return out;
}

bool is_grey(const std::vector<Rgb>& values) {
    return std::all_of(values.begin(), values.end(), [](const Rgb& c) { return c.x == c.y && c.y == c.z; });
}

bool is_grey(const Colors& values) { return is_grey(values.palette()); }

Box bounds_of(const Surfels& surfels) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    Box box{{inf, inf, inf}, {-inf, -inf, -inf}};
    const auto grow = [&box](const Vec3& p) {
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], p[axis]);
            box.high[axis] = std::max(box.high[axis], p[axis]);
        }
    };
    for (const Vec3& p : surfels.positions) grow(p);
    for (const Triangle& t : surfels.triangles) grow(t.a), grow(t.b), grow(t.c);
    return box;
}

}  // namespace surflux
