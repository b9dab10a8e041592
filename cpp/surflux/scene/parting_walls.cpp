#include "surflux/scene/parting_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace surflux {

namespace {

constexpr int side = 64;  // cells: a region of a thousandth has four

using Place = std::array<double, 2>;  // in cells, of which the first has its centre at 0

// The cells of a grid over a polygon, and the ways from each to the next.
class Cells {
public:
    Cells(const std::vector<Vec3>& polygon, const Vec3& normal) : origin_(polygon[0]) {
        // Along its longest edge: of a slender polygon whole rows are within.
        Vec3 longest;
        for (std::size_t k = 0; k < polygon.size(); ++k)
            if (const Vec3 edge = polygon[(k + 1) % polygon.size()] - polygon[k]; length(edge) > length(longest))
                longest = edge;
        axes_[0] = normalized(longest);
        axes_[1] = cross(normal, axes_[0]);
        for (std::size_t a = 0; a < 2; ++a) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (const Vec3& p : polygon) {
                const double at = dot(axes_[a], p - origin_);
                low = std::min(low, at), high = std::max(high, at);
            }
            cell_[a] = (high - low) / side;
            low_[a] = low + 0.5 * cell_[a];
        }
        for (int row = 0; row < side; ++row) fill_row(polygon, row);
    }

    double area() const { return cell_[0] * cell_[1]; }  // of one

    // Calls visit(a, b) for neighbours with a wall between their centres, of which the first is on its left.
    template <class Visit>
    void for_parted(const WallRun& run, double reach, const Visit& visit) const {
        const Vec3 more = reach * normalized(run.to - run.from);
        const Place from = place(run.from - more), to = place(run.to + more);
        for (std::size_t a = 0; a < 2; ++a) {  // along rows, then along columns
            const std::size_t b = 1 - a;
            const double low = std::clamp(std::min(from[b], to[b]), 0.0, 1.0 * side), high = std::max(from[b], to[b]);
            for (int line = static_cast<int>(std::ceil(low)); line < side && line < high; ++line) {
                const double at = from[a] + (line - from[b]) / (to[b] - from[b]) * (to[a] - from[a]);
                if (!(at > 0.0 && at <= side - 1)) continue;
                const int behind = static_cast<int>(std::ceil(at));
                const int next = a == 0 ? line * side + behind : behind * side + line, last = next - step(a);
                const bool ahead = a == 0 ? to[1] > from[1] : to[0] < from[0];  // is the next on the right?
                visit(ahead ? last : next, ahead ? next : last);
            }
        }
    }
    void part(int a, int b) { is_parted_[std::abs(b - a) == 1 ? 0 : 1][static_cast<std::size_t>(std::min(a, b))] = 1; }

    // Numbers the regions from 1 on, and says of how many cells each is; 0 are those that are not within.
    std::vector<std::size_t> number_regions() {
        std::vector<std::size_t> sizes{0};
        std::vector<int> open;
        for (int first = 0; first < side * side; ++first) {
            if (region(first) != unknown) continue;
            sizes.push_back(0);
            const auto number = static_cast<int>(sizes.size() - 1);
            const auto enter = [&](int cell) {
                if (region(cell) != unknown) return;
                region(cell) = number;
                ++sizes.back();
                open.push_back(cell);
            };
            enter(first);
            while (!open.empty()) {
                const int at = open.back(), x = at % side;
                open.pop_back();
                if (x + 1 < side && !is_parted(0, at)) enter(at + 1);
                if (x > 0 && !is_parted(0, at - 1)) enter(at - 1);
                if (at + side < side * side && !is_parted(1, at)) enter(at + side);
                if (at >= side && !is_parted(1, at - side)) enter(at - side);
            }
        }
        return sizes;
    }
    int region_of(int cell) const { return region_[static_cast<std::size_t>(cell)]; }

private:
    static constexpr int unknown = -1;
    static int step(std::size_t axis) { return axis == 0 ? 1 : side; }

    Place place(const Vec3& p) const {
        Place out;
        for (std::size_t a = 0; a < 2; ++a) out[a] = (dot(axes_[a], p - origin_) - low_[a]) / cell_[a];
        return out;
    }
    bool is_parted(std::size_t axis, int cell) const { return is_parted_[axis][static_cast<std::size_t>(cell)] != 0; }
    int& region(int cell) { return region_[static_cast<std::size_t>(cell)]; }

    // Which cells of a row have their centres within.
    void fill_row(const std::vector<Vec3>& polygon, int row) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Place a = place(polygon[k]), b = place(polygon[(k + 1) % polygon.size()]);
            if ((a[1] > row) == (b[1] > row)) continue;
            const double at = a[0] + (row - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            low = std::min(low, at), high = std::max(high, at);
        }
        for (int x = static_cast<int>(std::ceil(std::clamp(low, 0.0, 1.0 * side))); x < side && x <= high; ++x)
            region(row * side + x) = unknown;
    }

    Vec3 origin_, axes_[2];
    Place low_{}, cell_{};
    std::vector<int> region_ = std::vector<int>(side * side, 0);
    std::vector<char> is_parted_[2] = {std::vector<char>(side * side, 0), std::vector<char>(side * side, 0)};
};

}  // namespace

std::vector<std::uint32_t> parting_walls(const std::vector<Vec3>& polygon, const Vec3& normal,
                                         const std::vector<WallRun>& runs, double reach, double least_area) {
    Cells cells(polygon, normal);
    for (const WallRun& run : runs) cells.for_parted(run, reach, [&](int a, int b) { cells.part(a, b); });
    const std::vector<std::size_t> sizes = cells.number_regions();
    std::vector<char> is_closed_off(sizes.size(), 0);
    const auto see = [&](int region) {
        const auto size = static_cast<double>(sizes[static_cast<std::size_t>(region)]);
        is_closed_off[static_cast<std::size_t>(region)] = region > 0 && size * cells.area() >= least_area;
    };
    for (const WallRun& run : runs)
        cells.for_parted(run, reach, [&](int left, int right) {
            if (run.left) see(cells.region_of(left));
            if (run.right) see(cells.region_of(right));
        });
    is_closed_off[static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin())] = 0;
    std::vector<std::uint32_t> out;
    for (const WallRun& run : runs)
        cells.for_parted(run, reach, [&](int left, int right) {
            const auto a = static_cast<std::size_t>(cells.region_of(left)),
                       b = static_cast<std::size_t>(cells.region_of(right));
            if (a != b && (is_closed_off[a] != 0 || is_closed_off[b] != 0)) out.push_back(run.wall);
        });
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

}  // namespace surflux
