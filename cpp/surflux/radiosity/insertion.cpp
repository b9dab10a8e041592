#include "surflux/radiosity/insertion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/solution/interpolation.h"
#include "surflux/solution/slope_fit.h"

namespace surflux {

namespace {

constexpr std::size_t most_inserted = 50000;  // leaves more, unless it is said
constexpr double inside = 0.96;               // of the way to the rim of a patch is as far as children go

// A child at an offset in the plane of its parent, on a surface whose slope changes evenly from the parent's normal n
// to the child's.
Vec3 on_surface(const Vec3& center, const Vec3& n, const Vec3& offset, const Vec3& own) {
    return center + offset - (0.5 * dot(own, offset) / std::max(0.2, dot(own, n))) * n;
}

}  // namespace

double smallest_radius(const Surfels& s, double share) {
    double sum = 0.0, area = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) sum += s.areas[i] * s.radii[i] * s.radii[i], area += s.areas[i];
    return share * std::sqrt(sum / area);
}

std::size_t leaves_allowed(const Scene& scene, bool insert, std::size_t most) {
    if (!insert) return scene.surfels.size();
    if (most > 0) return std::min(most, 256 * scene.surfels.size());  // four times each to the smallest
    return scene.surfels.size() + std::min(scene.surfels.size(), most_inserted);
}

// Leaves of the objects in which any may be split, and their neighbourhoods.
struct Insertion::Leaves {
    std::vector<std::uint32_t> points;
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;
    std::unique_ptr<Interpolation> sites;

    Leaves(const Insertion& of, const Progress& progress) {
        const SurfelTree& tree = of.tree_;
        const std::vector<char> asked = of.asked();
        report(progress, 0, tree.points());
        for (std::uint32_t p = 0; p < tree.points(); ++p) {
            if (!asked[p] || !tree.is_leaf(p)) continue;
            points.push_back(p);
            positions.push_back(tree.position(p));
            normals.push_back(tree.normal(p));
            objects.push_back(tree.object(p));
        }
        sites = std::make_unique<Interpolation>(positions, normals, objects, standing_at(0, tree.points(), progress));
    }
};

struct Insertion::Neighborhood {
    Vec3 error;        // e_i of D04 eq. 12
    double off = 0.0;  // what interpolation to a neighbour may be off by
    std::vector<Interpolation::Weight> near;
};

Insertion::Insertion(SurfelTree& tree, const InsertionOptions& options, Team team)
    : tree_(tree), options_(options), team_(std::move(team)) {}

bool Insertion::can_split(std::uint32_t leaf) const {
    return tree_.is_leaf(leaf) && 0.5 * tree_.radius(leaf) >= options_.least_radius;
}

std::vector<char> Insertion::asked() const {
    std::vector<char> open, out(tree_.points());
    for (std::uint32_t p = 0; p < tree_.points(); ++p) {
        if (tree_.object(p) >= open.size()) open.resize(tree_.object(p) + 1, 0);
        if (can_split(p)) open[tree_.object(p)] = 1;
    }
    for (std::uint32_t p = 0; p < tree_.points(); ++p) out[p] = open[tree_.object(p)];
    return out;
}

// D04 eq. 11 and 12. A difference that neighbours on all sides have in proportion to their distance, the slope, is no
// error: fields are interpolated, so that only what departs from it is.
void Insertion::measure(const Leaves& leaves, std::uint32_t place, const std::vector<double>& values,
                        Neighborhood& out) const {
    const std::uint32_t i = leaves.points[place];
    out.error = {};
    out.off = 0.0;
    leaves.sites->nearest(leaves.positions[place], leaves.normals[place], leaves.objects[place],
                          whole_number(options_.tuning.leaves_around), out.near);
    const Frame frame = frame_around(leaves.normals[place]);
    SlopeFit<double> fit;
    for (const Interpolation::Weight& other : out.near) {
        const Vec3 d = leaves.positions[other.site] - leaves.positions[place];
        const double x = dot(d, frame.u), y = dot(d, frame.v), squared = length_squared(d);
        if (!(squared > 0.0)) continue;
        const double difference = values[leaves.points[other.site]] - values[i];
        out.error += (difference / std::sqrt(squared)) * d;
        fit.add(x, y, 1.0 / squared, difference);
    }
    double a, b;
    if (!fit.solve(a, b)) return;
    for (const Interpolation::Weight& other : out.near) {
        const Vec3 d = leaves.positions[other.site] - leaves.positions[place];
        const double rise = a * dot(d, frame.u) + b * dot(d, frame.v);
        // Halfway to a neighbour a step is off by half of it, and what curves by a quarter.
        out.off = std::max(out.off, 0.5 * std::abs(values[leaves.points[other.site]] - values[i] - rise));
    }
}

bool Insertion::refine(const OfPoint& value, const OfPoint& wanted, const Progress& progress) {
    const Leaves leaves(*this, progress);
    std::vector<double> values(tree_.points(), 0.0);
    parallel_for(leaves.points.size(), 512, [&](std::size_t k) { values[leaves.points[k]] = value(leaves.points[k]); });
    std::vector<double> off(leaves.points.size(), 0.0);
    const auto digest = [&] { return digest_of(values); };
    shared_blocks(
        team_, "insertion", digest, leaves.points.size(), 128,
        [&](std::size_t begin, std::size_t end) {
            Neighborhood around;
            for (std::size_t k = begin; k < end; ++k) {
                if (!can_split(leaves.points[k])) continue;
                measure(leaves, static_cast<std::uint32_t>(k), values, around);
                off[k] = around.off;
            }
        },
        [&](std::size_t begin, std::size_t end, Packed& to) { to.add(off.data() + begin, end - begin); },
        [&](std::size_t begin, std::size_t end, Unpacking& from) { from.take(off.data() + begin, end - begin); },
        progress);
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t k = 0; k < leaves.points.size(); ++k)
        if (off[k] * tree_.area(leaves.points[k]) > 0.0 && off[k] > wanted(leaves.points[k])) chosen.push_back(k);
    const auto weight = [&](std::uint32_t k) { return off[k] * off[k] * tree_.area(leaves.points[k]); };
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return weight(a) > weight(b); });
    std::vector<double> weights;
    for (std::uint32_t& k : chosen) {
        weights.push_back(weight(k));
        k = leaves.points[k];
    }
    const double least = least_weight(chosen, weights);
    std::size_t kept = 0;
    while (kept < chosen.size() && weights[kept] > least) ++kept;
    const std::size_t wanting = chosen.size(), before = tree_.points();
    if (kept > 0) chosen.resize(kept);  // else they are all alike: as many as there is room for
    const bool any = split(leaves, chosen, values, progress);
    left_out_ = wanting - (tree_.points() - before) / SurfelTree::children;
    return any;
}

// The weight, squared error times area, from which on leaves are split: such that what is above it goes down to where
// it is below, or to the smallest, before the room is used up. A border runs through two of four children, and each has
// a quarter of the weight, so that k times take 3 (2^k - 1) leaves.
double Insertion::least_weight(const std::vector<std::uint32_t>& leaves, const std::vector<double>& weights) const {
    const auto room = static_cast<double>(tree_.room());
    const auto taken = [&](double least) {
        double sum = 0.0;
        for (std::size_t k = 0; k < leaves.size() && weights[k] > least && sum <= room; ++k) {
            const double by_size = std::floor(std::log2(tree_.radius(leaves[k]) / options_.least_radius));
            const double by_weight = least > 0.0 ? std::ceil(std::log2(weights[k] / least) / 2.0) : by_size;
            sum += 3.0 * (std::exp2(std::min(by_size, by_weight)) - 1.0);
        }
        return sum;
    };
    if (leaves.empty() || taken(0.0) <= room) return 0.0;
    double low = std::log(weights.back()) - 1.0, high = std::log(weights.front());
    for (int round = 0; round < 40; ++round) {
        const double middle = 0.5 * (low + high);
        (taken(std::exp(middle)) > room ? low : high) = middle;
    }
    return std::exp(high);
}

bool Insertion::split(const Leaves& leaves, const std::vector<std::uint32_t>& chosen, const std::vector<double>& values,
                      const Progress& progress) {
    const auto first = static_cast<std::uint32_t>(tree_.points());
    if (chosen.empty() || !tree_.has_room()) return false;
    std::vector<std::uint32_t> place(tree_.points(), SurfelTree::none);
    for (std::uint32_t k = 0; k < leaves.points.size(); ++k) place[leaves.points[k]] = k;
    struct Family {
        SurfelTree::Child children[SurfelTree::children];
    };
    std::vector<Family> families(chosen.size());
    const NormalField& from = normals();
    parallel_blocks(chosen.size(), 32, [&](std::size_t begin, std::size_t end) {
        Neighborhood around;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t leaf = chosen[k];
            const Vec3 center = tree_.position(leaf), w = tree_.normal(leaf);
            measure(leaves, place[leaf], values, around);
            Vec3 v = around.error - dot(around.error, w) * w;
            v = length(v) > 1e-12 * length(around.error) && length(v) > 0.0 ? normalized(v) : frame_around(w).u;
            const Vec3 u = cross(v, w);
            const double reach = options_.tuning.spread_of_children * tree_.radius(leaf);
            const double signs[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
            for (std::size_t c = 0; c < SurfelTree::children; ++c) {
                SurfelTree::Child& child = families[k].children[c];
                child.position = center + (reach * signs[c][0]) * u + (reach * signs[c][1]) * v;
                child.normal = w;
                // That of its surfel, which B = E + rho H goes by; pictures blend between surfels.
                child.reflectance = tree_.reflectance(leaf);
                if (tree_.piece(leaf).empty())
                    child.normal = from.at(child.position, w, tree_.object(leaf));
                else
                    child.position = kept_on_patch(leaf, child.position);
            }
        }
    });
    for (std::size_t k = 0; k < chosen.size() && tree_.has_room(); ++k) tree_.split(chosen[k], families[k].children);
    repel(first, progress);
    return true;
}

// The point as far on the way from the centre as the patch reaches.
Vec3 Insertion::kept_on_patch(std::uint32_t leaf, const Vec3& wanted) const {
    const auto contains = [&](const Vec3& p) {
        for (const Triangle& t : tree_.piece(leaf)) {
            const Vec3 n = cross_of(t);
            const double least = -1e-9 * length_squared(n);
            if (dot(cross(t.b - t.a, p - t.a), n) >= least && dot(cross(t.c - t.b, p - t.b), n) >= least &&
                dot(cross(t.a - t.c, p - t.c), n) >= least)
                return true;
        }
        return false;
    };
    const Vec3& center = tree_.position(leaf);
    const Vec3 beyond = center + (wanted - center) / inside;
    if (contains(beyond)) return wanted;
    double low = 0.0, high = 1.0;
    for (int round = 0; round < 20; ++round) {
        const double middle = 0.5 * (low + high);
        (contains(center + middle * (beyond - center)) ? low : high) = middle;
    }
    return center + (inside * low) * (beyond - center);
}

void Insertion::repel(std::uint32_t first, const Progress& progress) {
    const auto count = static_cast<std::uint32_t>(tree_.points() - first);
    if (count == 0) return;
    const Leaves leaves(*this, progress);
    std::vector<std::uint32_t> parent(count);
    for (std::uint32_t p = 0; p < first; ++p)
        if (!tree_.is_leaf(p) && tree_.first_child(p) >= first)
            for (std::uint32_t c = 0; c < SurfelTree::children; ++c) parent[tree_.first_child(p) + c - first] = p;
    std::vector<std::vector<std::uint32_t>> near(count);
    parallel_for(count, 64, [&](std::size_t k) {
        thread_local std::vector<Interpolation::Weight> found;
        const std::uint32_t p = first + static_cast<std::uint32_t>(k);
        leaves.sites->nearest(tree_.position(p), tree_.normal(p), tree_.object(p),
                              static_cast<std::size_t>(std::lround(options_.tuning.repelling)), found);
        for (const Interpolation::Weight& other : found)
            if (leaves.points[other.site] != p) near[k].push_back(leaves.points[other.site]);
    });
    std::vector<Vec3> moved(count);
    for (int round = 0; round < std::lround(options_.tuning.repulsion_rounds); ++round) {
        parallel_for(count, 64, [&](std::size_t k) {
            const std::uint32_t p = first + static_cast<std::uint32_t>(k), from = parent[k];
            const Vec3 at = tree_.position(p), &n = tree_.normal(from), &center = tree_.position(from);
            const double spacing = std::sqrt(tree_.area(p));
            Vec3 force;
            for (std::uint32_t other : near[k]) {
                const Vec3 d = at - tree_.position(other);
                const double distance = length(d), wanted = 0.5 * (spacing + std::sqrt(tree_.area(other)));
                if (distance < wanted && distance > 0.0) force += ((wanted - distance) / distance) * d;
            }
            Vec3 offset = at + options_.tuning.repulsion_step * force - center;
            offset -= dot(offset, n) * n;
            const double most = options_.tuning.farthest_child * tree_.radius(from);
            if (length(offset) > most) offset *= most / length(offset);
            if (!tree_.piece(from).empty()) {
                moved[k] = kept_on_patch(from, center + offset);
                return;
            }
            moved[k] = on_surface(center, n, offset, tree_.normal(p));
        });
        for (std::uint32_t k = 0; k < count; ++k) tree_.move(first + k, moved[k]);
    }
    // What moved has the normal of where it came to.
    const NormalField& field = normals();
    parallel_for(count, 64, [&](std::size_t k) {
        const std::uint32_t p = first + static_cast<std::uint32_t>(k), from = parent[k];
        if (!tree_.piece(from).empty()) return;
        const Vec3 &at = tree_.position(p), &n = tree_.normal(from), &center = tree_.position(from);
        const Vec3 normal = field.at(at, n, tree_.object(p));
        moved[k] = on_surface(center, n, at - center - dot(at - center, n) * n, normal);
        tree_.turn(p, normal);
    });
    for (std::uint32_t k = 0; k < count; ++k)
        if (tree_.piece(parent[k]).empty()) tree_.move(first + k, moved[k]);
    for (std::uint32_t k = 0; k < count; k += SurfelTree::children)
        if (!tree_.piece(parent[k]).empty()) tree_.share_patch(parent[k]);
}

// Of the scene's own disks, wherever any may be split: what was inserted knows no more of the surface than they do, and
// from one generation to the next normals would only be blurred.
const NormalField& Insertion::normals() {
    if (normals_) return *normals_;
    const std::vector<char> open = asked();
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;
    for (std::uint32_t p = 0; p < tree_.points(); ++p) {
        if (!open[p] || tree_.surfel(p) != p || !tree_.piece(p).empty()) continue;
        positions.push_back(tree_.position(p));
        normals.push_back(tree_.normal(p));
        objects.push_back(tree_.object(p));
    }
    normals_ =
        std::make_unique<NormalField>(std::move(positions), std::move(normals), std::move(objects), options_.tuning);
    return *normals_;
}

}  // namespace surflux
