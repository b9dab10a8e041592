#include "surflux/meshless/dart_throwing.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr double usual_extent = 0.95;  // in R, of a part from its centre: two thirds of a median at most
constexpr double even = 0.125;         // in R: what is smaller is wanted as its centre is

// Looks at parts one after the other, in one window.
class Proposer {
public:
    Proposer(const Fill& fill, const PointGrid& grid, double density, std::uint64_t seed, Proposed& out)
        : fill_(fill),
          grid_(grid),
          near_(grid, fill.radius + usual_extent * fill.radius),
          parts_(fill.pieces),
          density_(density),
          seed_(seed),
          random_(seed),
          out_(out) {}

    // In the first window: cuts into parts no longer than 1.4 R.
    void begin(const Part& part) {
        if (part.path == 0) return again(part);
        enter(part.piece);
        cut(parts_.corners(part.piece, part.path), part.path, fill_.wanted != nullptr);
    }

    void again(const Part& part) {
        enter(part.piece);
        if (part.path == 0) return propose_center(part.piece);
        search(parts_.corners(part.piece, part.path), part.path);
    }

private:
    void enter(std::uint32_t piece) {
        piece_ = piece;
        surfel_ = fill_.pieces.surfel_of(piece);
        normal_ = fill_.scene.surfels.normals[surfel_];
    }

    bool wanted(const Vec3& at) const {
        return !fill_.wanted || fill_.wanted(at, normal_, static_cast<std::uint32_t>(fill_.object));
    }

    void cut(const Corners& t, std::uint32_t path, bool ask) {
        const double extent = longest_edge_squared(t), r2 = fill_.radius * fill_.radius;
        if (ask && extent <= 4.0 * r2) {
            const bool any =
                wanted(t.center()) || (extent > even * even * r2 && (wanted(t.a) || wanted(t.b) || wanted(t.c)));
            if (!any) return;
            ask = false;
        }
        if (extent <= 2.0 * r2 || path >> 31) return search(t, path);
        Corners first, second;
        bisect(t, first, second);
        cut(first, 2 * path, ask);
        cut(second, 2 * path + 1, ask);
    }

    void gather(const Vec3& center, double extent) {
        disks_.clear();
        const auto take = [&](const PointGrid::Point& p) {
            const double squared = length_squared(p.position - center), most = fill_.radius + extent;
            if (squared >= most * most) return;
            const double r = fill_.radius * dot(normal_, p.normal);
            if (r > 0.0 && squared < (r + extent) * (r + extent)) disks_.push_back({p.position, r});
        };
        if (extent <= usual_extent * fill_.radius) {
            for (const PointGrid::Point& p : near_.of(center)) take(p);
        } else {  // of a piece too large for the digits of a path
            const double reach = fill_.radius + extent;
            const Vec3 out{reach, reach, reach};
            grid_.within(grid_.cell_of(center - out), grid_.cell_of(center + out), take);
        }
    }

    void start_random(std::uint32_t path) { random_ = Random(seed_, (std::uint64_t{piece_} << 32) | path); }

    void propose_center(std::uint32_t piece) {
        const Vec3& at = fill_.scene.surfels.positions[surfel_];
        gather(at, 0.0);
        if (!disks_.empty() || !wanted(at)) return;
        start_random(0);
        if (comes(fill_.pieces.area(piece))) propose(at);
        out_.parts.push_back({piece, 0});
    }

    void search(const Corners& t, std::uint32_t path) {
        const Vec3 center = t.center();
        gather(center, extent_from(t, center));
        start_random(path);
        const std::uint32_t open = walk(t, area_of({t.a, t.b, t.c}), path, 0, disks_.size());
        if (open) out_.parts.push_back({piece_, open});
    }

    // Places on the part are rounded: far from the origin by more than a hair.
    static double extent_from(const Corners& t, const Vec3& center) {
        const double squared =
            std::max({length_squared(t.a - center), length_squared(t.b - center), length_squared(t.c - center)});
        return std::sqrt(squared) + 1e-15 * (std::abs(center.x) + std::abs(center.y) + std::abs(center.z));
    }

    // Proposes places on what no single disk covers. The path of the smallest part that contains it, 0 for nothing.
    std::uint32_t walk(const Corners& t, double area, std::uint32_t path, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
            if (disks_[k].holds(t.a) && disks_[k].holds(t.b) && disks_[k].holds(t.c)) return 0;
        if (area * density_ <= 1.0) {
            if (!comes(area)) return path;
            const double s = random_.uniform();
            const Vec3 w = square_to_triangle(s, random_.uniform()), at = w.x * t.a + w.y * t.b + w.z * t.c;
            bool free = true;
            for (std::size_t k = begin; free && k < end; ++k) free = !disks_[k].holds(at);
            if (free && wanted(at)) propose(at);
            return path;
        }
        Corners half[2];
        bisect(t, half[0], half[1]);
        std::uint32_t open[2];
        for (std::uint32_t h = 0; h < 2; ++h) {
            const Vec3 center = half[h].center();
            const double extent = extent_from(half[h], center);
            for (std::size_t k = begin; k < end; ++k) {
                const KeptDisk disk = disks_[k];
                const double reach = disk.radius + extent;
                if (length_squared(disk.center - center) < reach * reach) disks_.push_back(disk);
            }
            open[h] = walk(half[h], 0.5 * area, path >> 31 ? path : 2 * path + h, end, disks_.size());
            disks_.resize(end);
        }
        return open[0] && open[1] ? path : open[0] | open[1];
    }

    // Does a proposal come to that area in this window?
    bool comes(double area) { return random_.uniform() < area * density_; }

    void propose(const Vec3& at) {
        out_.proposals.push_back({at, random_.bits(), surfel_, static_cast<std::uint32_t>(out_.parts.size())});
    }

    const Fill& fill_;
    const PointGrid& grid_;
    Surroundings near_;
    PartFinder parts_;
    double density_;
    std::uint64_t seed_;
    Random random_;
    Proposed& out_;
    std::uint32_t piece_ = 0, surfel_ = 0;
    Vec3 normal_;
    std::vector<KeptDisk> disks_;
};

}  // namespace

Proposed propose(const Fill& fill, const PointGrid& grid, const Part* begin, const Part* end, double density,
                 std::uint64_t seed, bool first) {
    Proposed out;
    Proposer proposer(fill, grid, density, seed, out);
    for (const Part* part = begin; part < end; ++part)
        if (first)
            proposer.begin(*part);
        else
            proposer.again(*part);
    return out;
}

}  // namespace surflux
