#include "surflux/meshless/disk_fill.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/inside.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 512;
constexpr std::uint32_t none = 0xffffffffu;
constexpr double first_window = 1.0;   // proposals on a square of side R
constexpr double growth = 5.0;         // of their sum, with each further window
constexpr double usual_extent = 0.67;  // in R, of a part from its centre: two thirds of a median at most
constexpr double block_extent = 16.0;  // in R, of the parts that threads begin with
constexpr double spot = 0.125;         // in R: what is smaller is as its centre is
constexpr double dense_enough = 1.28, few_points = 4.0;

// What is not yet covered: a piece's part after some bisections. Path 0 is a disk small enough to stand for its centre.
struct Part {
    std::uint32_t piece, path;
};

struct Proposal {
    Vec3 position;
    std::uint64_t lot;  // the lower, the earlier
    std::uint32_t surfel;
    std::uint32_t part;  // its index among those that stay
};

struct Disk {
    Vec3 center;
    double radius;
};

// What a block of parts leaves behind.
struct Found {
    std::vector<Part> parts;
    std::vector<Proposal> proposals;
};

bool holds(const Disk& d, const Vec3& p) { return length_squared(p - d.center) < d.radius * d.radius; }

// Looks at parts one after the other, in one window.
class Walk {
public:
    Walk(const Fill& fill, const PointGrid& grid, double density, std::uint64_t seed, Found& out)
        : fill_(fill),
          grid_(grid),
          near_(grid, fill.radius + usual_extent * fill.radius),
          parts_(fill.pieces),
          density_(density),
          seed_(seed),
          random_(seed),
          out_(out) {}

    // In the first window: cuts into parts no longer than R.
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
                wanted(t.center()) || (extent > spot * spot * r2 && (wanted(t.a) || wanted(t.b) || wanted(t.c)));
            if (!any) return;
            ask = false;
        }
        if (extent <= r2 || path >> 31) return search(t, path);
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
        if (comes(2.0 * fill_.pieces.area(piece))) propose(at);
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
            if (holds(disks_[k], t.a) && holds(disks_[k], t.b) && holds(disks_[k], t.c)) return 0;
        if (area * density_ <= 1.0) {
            if (!comes(area)) return path;
            const double s = random_.uniform();
            const Vec3 w = square_to_triangle(s, random_.uniform()), at = w.x * t.a + w.y * t.b + w.z * t.c;
            bool free = true;
            for (std::size_t k = begin; free && k < end; ++k) free = !holds(disks_[k], at);
            if (free && (!fill_.pieces.is_disk(piece_) || fill_.pieces.within_ends(piece_, at)) && wanted(at))
                propose(at);
            return path;
        }
        Corners half[2];
        bisect(t, half[0], half[1]);
        std::uint32_t open[2];
        for (std::uint32_t h = 0; h < 2; ++h) {
            const Vec3 center = half[h].center();
            const double extent = extent_from(half[h], center);
            for (std::size_t k = begin; k < end; ++k) {
                const Disk disk = disks_[k];
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
    Found& out_;
    std::uint32_t piece_ = 0, surfel_ = 0;
    Vec3 normal_;
    std::vector<Disk> disks_;
};

// Which proposals of a window stand in each other's way, and the order in which they came.
struct Rivals {
    Rivals(const std::vector<Proposal>& proposals, const Fill& fill, const PointGrid& grid)
        : order(proposals.size()),
          lists_((order.size() + grain - 1) / grain),
          begin_(order.size()),
          end_(order.size()) {
        const auto normal_of = [&](std::size_t k) { return fill.scene.surfels.normals[proposals[k].surfel]; };
        const auto before = [&](std::uint32_t a, std::uint32_t b) {
            return proposals[a].lot != proposals[b].lot ? proposals[a].lot < proposals[b].lot : a < b;
        };
        PointGrid all(grid.low(), grid.side(), order.size());
        std::vector<PointGrid::Point> points(order.size());
        for (std::uint32_t k = 0; k < points.size(); ++k) points[k] = {proposals[k].position, normal_of(k), k};
        all.insert(points);
        points = {};
        parallel_blocks(order.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t>& list = lists_[begin / grain];
            Surroundings near(all, fill.radius);
            for (std::size_t k = begin; k < end; ++k) {
                const Vec3 at = proposals[k].position, normal = normal_of(k);
                begin_[k] = static_cast<std::uint32_t>(list.size());
                for (const PointGrid::Point& q : near.of(at)) {
                    if (length_squared(q.position - at) >= fill.radius * fill.radius) continue;
                    if (holds({q.position, fill.radius * std::max(0.0, dot(normal, q.normal))}, at) &&
                        before(q.index, static_cast<std::uint32_t>(k)))
                        list.push_back(q.index);
                }
                end_[k] = static_cast<std::uint32_t>(list.size());
            }
        });
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), before);
    }

    // Those that came before it and stand in its way.
    Span<std::uint32_t> earlier(std::uint32_t k) const {
        const std::uint32_t* list = lists_[k / grain].data();
        return {list + begin_[k], list + end_[k]};
    }

    std::vector<std::uint32_t> order;

private:
    std::vector<std::vector<std::uint32_t>> lists_;  // of each block of proposals
    std::vector<std::uint32_t> begin_, end_;
};

class DiskFill {
public:
    DiskFill(const Fill& fill, PointGrid& grid) : fill_(fill), grid_(grid) {}

    std::vector<FilledPoint> run(const Progress& progress) {
        const double r2 = fill_.radius * fill_.radius, n = fill_.rejections;
        const double all =
            std::max(dense_enough * std::pow(n, 2.0 / 3.0) / r2, few_points * n / fill_.pieces.area_of(fill_.object));
        split_large();
        std::vector<double> sums = {std::min(first_window / r2, all)};  // of proposals, up to each window's end
        while (sums.back() < all) sums.push_back(std::min(growth * sums.back(), all));
        for (std::size_t w = 0; w < sums.size() && !parts_.empty(); ++w) {
            const std::uint64_t seed = Random(fill_.seed, w).bits();
            const Progress in_window = [&](std::size_t done, std::size_t of) {
                return progress((w * of + done) * 1000 / (sums.size() * of), 1000);
            };
            look(w == 0 ? sums[0] : sums[w] - sums[w - 1], seed, w == 0, progress ? in_window : progress);
            accept(seed);
        }
        return std::move(out_);
    }

private:
    void split_large() {
        const double extent = block_extent * fill_.radius;
        std::vector<Part> rest;
        PartFinder finder(fill_.pieces);
        for (const std::uint32_t piece : fill_.pieces.of_object(fill_.object)) {
            if (fill_.pieces.is_disk(piece) && fill_.pieces.diagonal(piece) <= 2.0 * spot * fill_.radius) {
                parts_.push_back({piece, 0});
                continue;
            }
            rest.push_back({piece, 1});
            if (fill_.pieces.is_disk(piece)) rest.push_back({piece + 1, 1});
            while (!rest.empty()) {
                const Part part = rest.back();
                rest.pop_back();
                const Corners& t = finder.corners(part.piece, part.path);
                if (longest_edge_squared(t) <= extent * extent || part.path >> 31) {
                    parts_.push_back(part);
                } else {
                    rest.push_back({part.piece, 2 * part.path});
                    rest.push_back({part.piece, 2 * part.path + 1});
                }
            }
        }
    }

    void look(double density, std::uint64_t seed, bool first, const Progress& progress) {
        const std::size_t per_block = first ? grain / 8 : grain;
        std::vector<Found> found((parts_.size() + per_block - 1) / per_block);
        parallel_blocks(
            parts_.size(), per_block,
            [&](std::size_t begin, std::size_t end) {
                Found& out = found[begin / per_block];
                Walk walk(fill_, grid_, density, seed, out);
                for (std::size_t k = begin; k < end; ++k) {
                    if (parts_[k].piece == none) continue;
                    if (first)
                        walk.begin(parts_[k]);
                    else
                        walk.again(parts_[k]);
                }
            },
            progress);
        std::size_t parts = 0, proposals = 0;
        for (const Found& f : found) parts += f.parts.size(), proposals += f.proposals.size();
        require(parts < none, "radius: ", fill_.radius, " leaves too many parts of the surface to number");
        parts_.clear();
        parts_.reserve(parts);
        proposals_.clear();
        proposals_.reserve(proposals);
        for (Found& f : found) {
            const auto shift = static_cast<std::uint32_t>(parts_.size());
            for (Proposal& p : f.proposals) p.part += shift;
            parts_.insert(parts_.end(), f.parts.begin(), f.parts.end());
            proposals_.insert(proposals_.end(), f.proposals.begin(), f.proposals.end());
            f = {};
        }
    }

    const Vec3& normal_of(const Proposal& p) const { return fill_.scene.surfels.normals[p.surfel]; }

    // Takes the proposals in the order of their lots; those inside geometry are not there and bar none.
    void accept(std::uint64_t seed) {
        const Rivals rivals(proposals_, fill_, grid_);
        std::vector<std::uint32_t> rest = rivals.order;
        std::vector<PointGrid::Point> added;
        enum : char { open, accepted, barred, inside };
        std::vector<char> state(proposals_.size(), open);
        // As if none were inside. Where some turn out to be, those that they barred come again.
        for (bool again = true; again;) {
            std::vector<std::uint32_t> chosen;
            for (const std::uint32_t k : rest) {
                if (state[k] != open) continue;
                const Span<std::uint32_t> earlier = rivals.earlier(k);
                if (std::any_of(earlier.begin(), earlier.end(), [&](std::uint32_t j) { return state[j] == accepted; }))
                    continue;
                state[k] = accepted;
                chosen.push_back(k);
            }
            std::vector<Departure> places(chosen.size());
            parallel_for(chosen.size(), grain, [&](std::size_t k) {
                const Proposal& p = proposals_[chosen[k]];
                places[k] = {p.position, normal_of(p), p.surfel};
            });
            const std::vector<char> is_inside = inside_geometry(fill_.scene, fill_.tracer, places, seed);
            std::vector<std::uint32_t> lost;  // parts
            for (std::size_t k = 0; k < chosen.size(); ++k) {
                const Proposal& p = proposals_[chosen[k]];
                if (is_inside[k]) {
                    state[chosen[k]] = inside;
                    lost.push_back(p.part);
                } else {
                    for (const std::uint32_t j : rivals.earlier(chosen[k]))
                        if (state[j] == open) state[j] = barred;
                    added.push_back({p.position, normal_of(p), p.surfel});
                    out_.push_back({p.position, p.surfel});
                }
            }
            again = !lost.empty();
            if (!again) break;
            drop_inside(lost);
            rest.erase(std::remove_if(rest.begin(), rest.end(),
                                      [&](std::uint32_t k) {
                                          return state[k] != open || parts_[proposals_[k].part].piece == none;
                                      }),
                       rest.end());
        }
        grid_.insert(added);
    }

    // A part with a place inside geometry gets no more proposals if its corners are under backs, too.
    void drop_inside(const std::vector<std::uint32_t>& lost) {
        std::vector<Departure> places;
        PartFinder finder(fill_.pieces);
        for (const std::uint32_t k : lost) {
            const Part part = parts_[k];
            if (part.path == 0) continue;
            const std::uint32_t surfel = fill_.pieces.surfel_of(part.piece);
            const Corners& t = finder.corners(part.piece, part.path);
            for (const Vec3* corner : {&t.a, &t.b, &t.c})
                places.push_back(
                    {*corner + 0.01 * (t.center() - *corner), fill_.scene.surfels.normals[surfel], surfel});
        }
        const std::vector<char> under = under_backs(fill_.scene, fill_.tracer, places);
        std::size_t at = 0;
        for (const std::uint32_t k : lost) {
            const bool is_point = parts_[k].path == 0;
            if (is_point || (under[at] && under[at + 1] && under[at + 2])) parts_[k].piece = none;
            if (!is_point) at += 3;
        }
    }

    const Fill& fill_;
    PointGrid& grid_;
    std::vector<Part> parts_;
    std::vector<Proposal> proposals_;
    std::vector<FilledPoint> out_;
};

}  // namespace

std::vector<FilledPoint> fill_disks(const Fill& fill, PointGrid& grid, const Progress& progress) {
    return DiskFill(fill, grid).run(progress);
}

}  // namespace surflux
