#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

struct Neighbor {
    std::uint32_t index;
    double distance;  // actual, not squared
};

// Exact nearest neighbours among fixed points. Queries are const and may run on many threads at once.
// A k-d tree over FLANN's, of some ten thousand neighbouring points each: these are built side by side, and a cancelled
// pass waits for no more than one of them.
class PointIndex {
public:
    explicit PointIndex(const std::vector<Vec3>& points, const Progress& progress = {});
    ~PointIndex();
    PointIndex(PointIndex&&) noexcept;
    PointIndex& operator=(PointIndex&&) noexcept;

    // The min(k, size) nearest, or fewer where fewer are at most `radius` away; nearest first, ties by index.
    // A query at a point of the index finds that point too.
    void nearest(const Vec3& query, std::size_t k, std::vector<Neighbor>& out,
                 double radius = std::numeric_limits<double>::infinity()) const;
    // All at most `radius` away, in no particular order, appended to `out`.
    void within(const Vec3& query, double radius, std::vector<Neighbor>& out) const;

    std::size_t size() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

std::string flann_version();

}  // namespace surflux
