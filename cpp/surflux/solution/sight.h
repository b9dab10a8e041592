#pragma once

#include <vector>

#include "surflux/solution/interpolation.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Which places of one object are neighbours: those with nothing standing between them. A floor goes on beneath a thin
// wall, and its light does not.
class Sight {
public:
    explicit Sight(const Tracer& tracer) : tracer_(tracer) {}

    // Is the way free from one to the other, a little above the surface? Two heights are tried, for what lies between
    // two sheets and for what curves.
    bool joined(const Vec3& p, const Vec3& normal_p, const Vec3& q, const Vec3& normal_q) const;
    // Drops from the weights at a place what it is not joined with, where values differ so much that it matters. One
    // weight stays at least.
    void keep_joined(const Vec3& point, const Vec3& normal, const std::vector<Vec3>& positions,
                     const std::vector<Vec3>& normals, const std::vector<double>& values,
                     std::vector<Interpolation::Weight>& weights) const;

private:
    const Tracer& tracer_;
};

// Values of which one is less than three quarters of the other.
inline bool differ_much(double a, double b) { return a < 0.75 * b || b < 0.75 * a; }

}  // namespace surflux
