#include "surflux/scene/divided_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "surflux/core/clip_polygon.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/scene/box_tree.h"
#include "surflux/scene/parting_walls.h"

namespace surflux {

namespace {

constexpr double least_sine = 0.2;    // of the angle between a wall and a patch: what is flatter is relief
constexpr double slit_height = 0.02;  // of a patch's width; walls that rise by half as much count
constexpr double least_cover = 0.5;   // of a piece's width, by all walls together
constexpr double one_plane = 1e-3;    // radians, and of a patch's width: walls closer are in one plane
// The same of walls that stand before each other, as a pane does that is modelled twice: what is between is out of
// sight on both sides of them, and goes with either.
constexpr double one_sheet = 1e-2;
constexpr std::size_t most_lines = 256;
constexpr double snap = 1e-9;  // of a patch's diameter: a cut so close to a corner goes through it

Vec3 vector_area(const Vec3* corners, std::size_t count) {
    Vec3 sum;
    for (std::size_t k = 2; k < count; ++k) sum += cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
    return 0.5 * sum;
}

}  // namespace

PatchDivider::PatchDivider(const Vec3* corners, std::size_t count, const DivisionOptions& options)
    : options_(options), given_(corners), corners_(corners, corners + count) {
    for (std::size_t k = 0; k < count; ++k) middle_ += (corners[k] - corners[0]) / static_cast<double>(count);
    middle_ += corners[0];
    for (Vec3& p : corners_) p -= middle_;
    const Vec3 area = vector_area(corners_.data(), count);
    area_ = length(area);
    frame_ = frame_around(area / area_);
    for (const Vec3& a : corners_)
        for (const Vec3& b : corners_) diameter_ = std::max(diameter_, length(a - b));
    slit_ = slit_height * area_ / diameter_;
}

void PatchDivider::add_wall(const Vec3* corners, std::size_t count) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (std::size_t k = 0; k < count; ++k) {
        const double height = dot(frame_.n, corners[k] - middle_);
        lowest = std::min(lowest, height), highest = std::max(highest, height);
    }
    if (!(lowest <= slit_ && highest >= 0.5 * slit_)) return;
    const Vec3 plane = normalized(vector_area(corners, count));
    const Vec3 trace = cross(frame_.n, plane);
    const double sine = length(trace);
    if (!(sine >= least_sine)) return;

    Line line;
    line.along = trace / sine;
    line.normal = cross(line.along, frame_.n);
    line.offset = dot(plane, corners[0] - middle_) / dot(plane, line.normal);
    Run run{{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}, true, false};
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 a = corners[k] - middle_, b = corners[(k + 1) % count] - middle_;
        const double at_a = dot(frame_.n, a), at_b = dot(frame_.n, b);
        double from = 0.0, to = 1.0;  // the part of the edge between -slit and slit
        if (at_a != at_b) {
            const double s = (-slit_ - at_a) / (at_b - at_a), t = (slit_ - at_a) / (at_b - at_a);
            from = std::max(from, std::min(s, t)), to = std::min(to, std::max(s, t));
        } else if (std::abs(at_a) > slit_) {
            continue;
        }
        if (from > to) continue;
        for (const double share : {from, to}) {
            const double at = dot(line.along, a + share * (b - a));
            run.low = std::min(run.low, at), run.high = std::max(run.high, at);
        }
    }
    const Interval across = chord(corners_, line);
    run.low = std::max(run.low, across.low), run.high = std::min(run.high, across.high);
    if (!(run.low < run.high) || !parts(corners_, area_, line)) return;
    line.length = run.high - run.low;
    line.covered = {run};
    lines_.push_back(std::move(line));
}

// Faces of one plane, but for rounding, become one line, the longest; then sheets that lie closely over each other do.
// The longest `most_lines` stay.
void PatchDivider::merge_lines() {
    using Bin = std::pair<std::int64_t, std::int64_t>;
    std::vector<std::tuple<Bin, double, std::uint32_t>> order;
    const double width = area_ / diameter_;
    for (std::uint32_t k = 0; k < lines_.size(); ++k) {
        Line& line = lines_[k];
        // Bins begin at odd places, for walls mostly stand at round ones.
        double angle = std::atan2(dot(line.normal, frame_.v), dot(line.normal, frame_.u)) + 0.3717;
        if (angle < 0.0 || angle >= pi) {
            angle += angle < 0.0 ? pi : -pi;
            line.normal = -line.normal, line.along = -line.along, line.offset = -line.offset;
            for (Run& run : line.covered) run = {{-run.high, -run.low}, run.back, run.front};
        }
        const auto bin = [](double x) { return static_cast<std::int64_t>(std::floor(x + 0.3717)); };
        order.push_back({{bin(angle / one_plane), bin(line.offset / (one_plane * width))}, -line.length, k});
    }
    std::sort(order.begin(), order.end());
    std::vector<Line> planes;
    for (std::size_t begin = 0, end; begin < order.size(); begin = end) {
        Line line = lines_[std::get<2>(order[begin])];
        for (end = begin + 1; end < order.size() && std::get<0>(order[end]) == std::get<0>(order[begin]); ++end)
            line.covered.push_back(lines_[std::get<2>(order[end])].covered.front());
        line.join_runs();
        planes.push_back(std::move(line));
    }
    std::stable_sort(planes.begin(), planes.end(), [](const Line& a, const Line& b) { return a.length > b.length; });
    if (planes.size() > most_lines) planes.resize(most_lines);
    lines_.clear();
    for (Line& line : planes) {
        const auto lies_over = [&](const Line& longer) {
            return std::abs(dot(line.along, longer.normal)) <= one_sheet && dot(line.normal, longer.normal) > 0.0 &&
                   std::abs(line.offset - longer.offset) <= one_sheet * width &&
                   line.overlap(longer) > 0.5 * line.length;
        };
        const auto over = std::find_if(lines_.begin(), lines_.end(), lies_over);
        if (over == lines_.end()) {
            lines_.push_back(std::move(line));
            continue;
        }
        over->covered.insert(over->covered.end(), line.covered.begin(), line.covered.end());
        over->join_runs();
    }
}

void PatchDivider::Line::join_runs() {
    std::sort(covered.begin(), covered.end(), [](const Run& a, const Run& b) { return a.low < b.low; });
    std::size_t last = 0;
    for (std::size_t k = 1; k < covered.size(); ++k) {
        Run &joined = covered[last], &run = covered[k];
        if (run.low <= joined.high)
            joined = {
                {joined.low, std::max(joined.high, run.high)}, joined.front || run.front, joined.back || run.back};
        else
            covered[++last] = run;
    }
    covered.resize(last + 1);
    length = 0.0;
    for (const Run& run : covered) length += run.high - run.low;
}

double PatchDivider::Line::within(const Interval& part) const {
    double sum = 0.0;
    for (const Run& run : covered) sum += std::max(0.0, std::min(run.high, part.high) - std::max(run.low, part.low));
    return sum;
}

double PatchDivider::Line::overlap(const Line& other) const {
    double sum = 0.0;
    for (const Run& run : covered) sum += other.within(run);
    return sum;
}

double PatchDivider::area_of(const Polygon& polygon) const {
    return polygon.size() < 3 ? 0.0 : dot(frame_.n, vector_area(polygon.data(), polygon.size()));
}

PatchDivider::Interval PatchDivider::chord(const Polygon& polygon, const Line& line) const {
    Interval out{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        const double at_a = dot(line.normal, a) - line.offset, at_b = dot(line.normal, b) - line.offset;
        if ((at_a > 0.0) == (at_b > 0.0)) continue;
        const double at = dot(line.along, a + at_a / (at_a - at_b) * (b - a));
        out.low = std::min(out.low, at), out.high = std::max(out.high, at);
    }
    return out;
}

bool PatchDivider::parts(const Polygon& polygon, double area, const Line& line) const {
    thread_local Polygon inside;
    inside.clear();
    clip_polygon(
        polygon.data(), polygon.size(), line.normal, line.offset, [](const Vec3& p) { inside.push_back(p); },
        [](const Vec3&) {});
    const double part = area_of(inside);
    return std::min(part, area - part) >= options_.least_share * area_;
}

// The line of which walls cover most, where they cover enough together, or of those that close off a part of it; those
// that do not part the piece it forgets.
const PatchDivider::Line* PatchDivider::best_line(Piece& piece) const {
    std::vector<double> covers;
    for (std::size_t k = 0; k < piece.lines.size();) {
        const Line& line = lines_[piece.lines[k]];
        const Interval across = chord(piece.corners, line);
        const double cover = line.within(across);
        if (cover > 0.0 && parts(piece.corners, piece.area, line)) {
            covers.push_back(cover / (across.high - across.low));
            ++k;
        } else {
            piece.lines.erase(piece.lines.begin() + static_cast<std::ptrdiff_t>(k));
        }
    }
    const auto longest = [&](const std::vector<std::uint32_t>& of) {
        const auto shorter = [&](std::uint32_t a, std::uint32_t b) { return covers[a] < covers[b]; };
        const auto most = std::max_element(of.begin(), of.end(), shorter);
        return most == of.end() ? nullptr : &lines_[piece.lines[*most]];
    };
    if (std::accumulate(covers.begin(), covers.end(), 0.0) < least_cover) return longest(parting(piece));
    std::vector<std::uint32_t> all(covers.size());
    std::iota(all.begin(), all.end(), 0u);
    return longest(all);
}

// Of the lines of a piece, by their places there, those whose walls close off a part of it together.
std::vector<std::uint32_t> PatchDivider::parting(const Piece& piece) const {
    if (piece.lines.size() < 2) return {};
    std::vector<WallRun> runs;
    for (std::uint32_t k = 0; k < piece.lines.size(); ++k) {
        const Line& line = lines_[piece.lines[k]];
        const Vec3 foot = line.offset * line.normal;
        for (const Run& run : line.covered)
            runs.push_back({foot + run.low * line.along, foot + run.high * line.along, run.front, run.back, k});
    }
    return parting_walls(piece.corners, frame_.n, runs, slit_, options_.least_share * area_);
}

std::vector<std::vector<Vec3>> PatchDivider::pieces() {
    merge_lines();
    std::vector<Piece> pieces{{corners_, {}, area_, lines_.empty()}};
    for (std::uint32_t k = 0; k < lines_.size(); ++k) pieces[0].lines.push_back(k);
    while (pieces.size() < options_.most_pieces) {
        Piece* largest = nullptr;
        for (Piece& piece : pieces)
            if (!piece.is_done && (!largest || piece.area > largest->area)) largest = &piece;
        if (!largest) break;
        const Line* line = best_line(*largest);
        if (!line) {
            largest->is_done = true;
            continue;
        }
        Piece inside{{}, largest->lines, 0.0, false}, outside = inside;
        clip_polygon(
            largest->corners.data(), largest->corners.size(), line->normal, line->offset,
            [&](const Vec3& p) { inside.corners.push_back(p); }, [&](const Vec3& p) { outside.corners.push_back(p); },
            snap * diameter_);
        inside.area = area_of(inside.corners), outside.area = area_of(outside.corners);
        *largest = std::move(inside);
        pieces.push_back(std::move(outside));
    }
    std::vector<Polygon> out;
    for (const Piece& piece : pieces) {
        out.push_back(piece.corners);
        for (Vec3& p : out.back()) {
            const auto own = std::find(corners_.begin(), corners_.end(), p);
            p = own != corners_.end() ? given_[own - corners_.begin()] : middle_ + p;
        }
    }
    return out;
}

namespace {

Box box_of(const FlatPolygons& polygons, std::size_t p) {
    const Vec3* corners = polygons.of(p);
    Box box{corners[0], corners[0]};
    for (std::size_t k = 1; k < polygons.count(p); ++k)
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], corners[k][axis]);
            box.high[axis] = std::max(box.high[axis], corners[k][axis]);
        }
    return box;
}

BoxTree tree_of(const FlatPolygons& polygons) {
    std::vector<Box> boxes(polygons.size());
    parallel_for(boxes.size(), 4096, [&](std::size_t p) { boxes[p] = box_of(polygons, p); });
    return BoxTree(boxes);
}

// FlatPolygons that may be walls on a patch, ascending.
void find_walls(const BoxTree& walls, const PatchDivider& patch, Box around, const Vec3& corner,
                std::vector<std::uint32_t>& out) {
    const Vec3 n = patch.normal();
    const double slit = patch.slit();
    for (int axis = 0; axis < 3; ++axis) {
        around.low[axis] += std::min(0.0, slit * n[axis]);
        around.high[axis] += std::max(0.0, slit * n[axis]);
    }
    out.clear();
    walls.visit(
        [&](const Box& box) {
            double lowest = 0.0, highest = 0.0;  // over the patch
            for (int axis = 0; axis < 3; ++axis) {
                if (box.low[axis] > around.high[axis] || box.high[axis] < around.low[axis]) return false;
                const double a = n[axis] * (box.low[axis] - corner[axis]),
                             b = n[axis] * (box.high[axis] - corner[axis]);
                lowest += std::min(a, b), highest += std::max(a, b);
            }
            return lowest <= slit && highest >= 0.5 * slit;
        },
        [&](std::uint32_t wall) { out.push_back(wall); });
    std::sort(out.begin(), out.end());
}

}  // namespace

DividedPatches divide_patches(const FlatPolygons& patches, const FlatPolygons& walls, const Progress& progress,
                              const DivisionOptions& options) {
    const BoxTree tree = tree_of(walls);
    std::vector<double> area(patches.size());
    parallel_for(area.size(), 4096,
                 [&](std::size_t p) { area[p] = length(vector_area(patches.of(p), patches.count(p))); });
    std::vector<std::uint32_t> order(patches.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });

    using Pieces = std::vector<std::vector<Vec3>>;
    std::map<std::uint32_t, Pieces> divided;
    const std::size_t most = std::max(options.most_added, patches.size() / 20);
    constexpr std::size_t round = 4096;
    std::vector<Pieces> found;
    for (std::size_t first = 0, added = 0; first < order.size() && added < most; first += round) {
        found.assign(std::min(round, order.size() - first), {});
        const Progress of_all = [&](std::size_t done, std::size_t) {
            return !progress || progress(first + done, order.size());
        };
        parallel_blocks(
            found.size(), 16,
            [&](std::size_t begin, std::size_t end) {
                std::vector<std::uint32_t> near;
                for (std::size_t k = begin; k < end; ++k) {
                    const std::uint32_t p = order[first + k];
                    PatchDivider divider(patches.of(p), patches.count(p), options);
                    find_walls(tree, divider, box_of(patches, p), patches.of(p)[0], near);
                    for (const std::uint32_t w : near) divider.add_wall(walls.of(w), walls.count(w));
                    if (divider.has_walls()) found[k] = divider.pieces();
                }
            },
            of_all);
        for (std::size_t k = 0; k < found.size(); ++k) {
            if (found[k].size() < 2 || added + found[k].size() - 1 > most) continue;
            added += found[k].size() - 1;
            divided[order[first + k]] = std::move(found[k]);
        }
    }

    DividedPatches out;
    for (const auto& [patch, pieces] : divided)
        for (const std::vector<Vec3>& piece : pieces) {
            out.pieces.corners.insert(out.pieces.corners.end(), piece.begin(), piece.end());
            out.pieces.begin.push_back(out.pieces.corners.size());
            out.patch.push_back(patch);
        }
    return out;
}

}  // namespace surflux
