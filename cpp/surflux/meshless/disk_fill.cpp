#include "surflux/meshless/disk_fill.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/meshless/conflict_graph.h"
#include "surflux/meshless/inside.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 512;
constexpr std::uint32_t none = 0xffffffffu;  // for a part that gets no more proposals
constexpr double first_window = 1.0;         // proposals on a square of side R
constexpr double growth = 5.0;               // of their sum, with each further window
constexpr double block_extent = 16.0;        // in R, of the parts that threads begin with
constexpr double dense_enough = 0.64, few_points = 4.0;

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
            if (fill_.pieces.is_disk(piece)) {
                parts_.push_back({piece, 0});
                continue;
            }
            rest.push_back({piece, 1});
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
        parts_.erase(std::remove_if(parts_.begin(), parts_.end(), [](const Part& p) { return p.piece == none; }),
                     parts_.end());
        const std::size_t per_block = first ? grain / 8 : grain;
        std::vector<Proposed> found((parts_.size() + per_block - 1) / per_block);
        parallel_blocks(
            parts_.size(), per_block,
            [&](std::size_t begin, std::size_t end) {
                found[begin / per_block] =
                    propose(fill_, grid_, parts_.data() + begin, parts_.data() + end, density, seed, first);
            },
            progress);
        std::size_t parts = 0, proposals = 0;
        for (const Proposed& f : found) parts += f.parts.size(), proposals += f.proposals.size();
        require(parts < none, "radius: ", fill_.radius, " leaves too many parts of the surface to number");
        parts_.clear();
        parts_.reserve(parts);
        proposals_.clear();
        proposals_.reserve(proposals);
        for (Proposed& f : found) {
            const auto shift = static_cast<std::uint32_t>(parts_.size());
            for (Proposal& p : f.proposals) p.part += shift;
            parts_.insert(parts_.end(), f.parts.begin(), f.parts.end());
            proposals_.insert(proposals_.end(), f.proposals.begin(), f.proposals.end());
            f = {};
        }
    }

    const Vec3& normal_of(const Proposal& p) const { return fill_.scene.surfels.normals[p.surfel]; }

    // Takes the proposals in the order of their priorities; those inside geometry are not there and bar none.
    void accept(std::uint64_t seed) {
        const ConflictGraph conflicts(proposals_, fill_, grid_);
        std::vector<std::uint32_t> rest = conflicts.order;
        std::vector<PointGrid::Point> added;
        enum : char { open, accepted, barred, inside };
        std::vector<char> state(proposals_.size(), open);
        // As if none were inside. Where some turn out to be, those that they barred come again.
        for (bool again = true; again;) {
            std::vector<std::uint32_t> chosen;
            for (const std::uint32_t k : rest) {
                if (state[k] != open) continue;
                const Span<std::uint32_t> earlier = conflicts.earlier(k);
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
                    for (const std::uint32_t j : conflicts.earlier(chosen[k]))
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
