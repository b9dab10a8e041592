#include "surflux/area/border.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surflux {

void hull_sides(std::vector<Point2>& points, std::vector<HalfPlane>& sides) {
    sides.clear();
    if (points.size() < 3) return;
    // Andrew's monotone chain: the lower hull from left to right, then the upper one back.
    std::sort(points.begin(), points.end(),
              [](const Point2& a, const Point2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    std::vector<Point2> hull;
    const auto extend = [&hull](const Point2& p, std::size_t begin) {
        while (hull.size() >= begin + 2) {
            const Point2 a = hull[hull.size() - 2], b = hull.back();
            if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0.0) break;
            hull.pop_back();
        }
        hull.push_back(p);
    };
    for (const Point2& p : points) extend(p, 0);
    const std::size_t upper = hull.size() - 1;
    for (std::size_t k = points.size() - 1; k-- > 0;) extend(points[k], upper);
    hull.pop_back();
    if (hull.size() < 3) return;
    for (std::size_t k = 0; k < hull.size(); ++k) {
        const Point2 a = hull[k], b = hull[(k + 1) % hull.size()];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        const double x = (b.y - a.y) / length, y = -(b.x - a.x) / length;
        sides.push_back({x, y, x * a.x + y * a.y});
    }
}

void sharpen_corners(std::vector<HalfPlane>& sides, double tolerance) {
    while (sides.size() > 3) {
        std::size_t least = 0;
        double least_height = tolerance;
        for (std::size_t k = 0; k < sides.size(); ++k) {
            const HalfPlane &a = sides[(k + sides.size() - 1) % sides.size()], &b = sides[(k + 1) % sides.size()];
            const double turn = a.x * b.y - a.y * b.x;
            if (turn <= 1e-9) continue;  // they do not meet beyond
            const double x = (a.limit * b.y - b.limit * a.y) / turn, y = (a.x * b.limit - b.x * a.limit) / turn;
            const double height = sides[k].x * x + sides[k].y * y - sides[k].limit;
            if (height < least_height) {
                least = k;
                least_height = height;
            }
        }
        if (least_height >= tolerance) return;
        sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(least));
    }
}

}  // namespace surflux
