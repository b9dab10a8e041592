#include "surflux/meshless/multilevel_basis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 512;
constexpr std::size_t large = 50000;  // functions

double magnitude(double value) { return std::abs(value); }
double magnitude(const Rgb& value) { return std::max({std::abs(value.x), std::abs(value.y), std::abs(value.z)}); }

// By what functions of a level that corrects a coarser one are less than a partition of unity where they hardly reach:
// a function that is alone at its rim would end in a step, of its whole coefficient (L07 has points on all of each
// level and steps nowhere; ours are only where they are wanted). Within a level weights sum up to 2 or more.
double at_rim(double sum) { return sum >= 1.0 ? 1.0 : sum * sum * (3.0 - 2.0 * sum); }

}  // namespace

void MultilevelBasis::add_level(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                const std::vector<std::uint32_t>& objects, const SupportOptions& options) {
    require(positions.size() < std::numeric_limits<std::uint32_t>::max() - positions_.size(), "positions: there are ",
            positions.size(), " besides ", positions_.size(), " on coarser levels, wanted fewer than 2^32 in all");
    levels_.emplace_back(positions, normals, objects, options);
    positions_.insert(positions_.end(), positions.begin(), positions.end());
    normals_.insert(normals_.end(), normals.begin(), normals.end());
    objects_.insert(objects_.end(), objects.begin(), objects.end());
    first_.push_back(static_cast<std::uint32_t>(positions_.size()));
}

void MultilevelBasis::set_cuts(std::vector<SupportCut> cuts) {
    for (SupportCut& cut : cuts) cut.function -= first_[levels() - 1];
    levels_.back().set_cuts(std::move(cuts));
}

std::size_t MultilevelBasis::level_of(std::uint32_t function) const {
    return static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), function) - first_.begin()) - 1;
}

bool MultilevelBasis::is_coarsest(std::size_t level, std::uint32_t object) const {
    for (std::size_t above = 0; above < level; ++above)
        if (levels_[above].has(object)) return false;
    return levels_[level].has(object);
}

void MultilevelBasis::weights(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                              std::vector<BasisWeight>& out) const {
    levels_[level].weights(point, normal, object, out);
    if (out.empty() && is_coarsest(level, object)) levels_[level].at_or_nearest(point, normal, object, out);
    for (BasisWeight& w : out) w.function += first_[level];
}

void MultilevelBasis::to_shares(std::size_t level, std::uint32_t object, std::vector<BasisWeight>& weights) const {
    double sum = 0.0;
    for (const BasisWeight& w : weights) sum += w.weight;
    const double fade = sum >= 1.0 || is_coarsest(level, object) ? 1.0 : at_rim(sum);
    for (BasisWeight& w : weights) w.weight *= fade / sum;
}

void MultilevelBasis::at_level(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                               std::vector<BasisWeight>& out) const {
    weights(level, point, normal, object, out);
    to_shares(level, object, out);
}

template <class Value>
Value MultilevelBasis::evaluate(const Vec3& point, const Vec3& normal, std::uint32_t object,
                                const std::vector<Value>& coefficients, std::size_t up_to) const {
    require(coefficients.size() == size(), "coefficients: there are ", coefficients.size(), ", wanted ", size());
    thread_local std::vector<BasisWeight> weights;
    Value value{};
    for (std::size_t level = 0; level < levels() && level <= up_to; ++level) {
        at_level(level, point, normal, object, weights);
        for (const BasisWeight& w : weights) value += w.weight * coefficients[w.function];
    }
    return value;
}

template <class Value>
std::vector<Value> MultilevelBasis::evaluate(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                                             const std::vector<std::uint32_t>& objects,
                                             const std::vector<Value>& coefficients, std::size_t up_to) const {
    require(normals.size() == points.size(), "normals: there are ", normals.size(), ", wanted one for each of ",
            points.size(), " points");
    require(objects.size() == points.size(), "objects: there are ", objects.size(), ", wanted one for each of ",
            points.size(), " points");
    require(coefficients.size() == size(), "coefficients: there are ", coefficients.size(), ", wanted ", size());
    std::vector<Value> out(points.size());
    // One near the other: of a large basis little is in the caches, and points at random cost five times as much.
    std::vector<std::uint32_t> along;
    if (size() > large) along = morton_order(points);
    parallel_for(points.size(), grain, [&](std::size_t k) {
        const std::size_t i = along.empty() ? k : along[k];
        out[i] = evaluate(points[i], normals[i], objects[i], coefficients, up_to);
    });
    return out;
}

template <class Value>
Value MultilevelBasis::coefficient(std::uint32_t function, const Value& value,
                                   const std::vector<Value>& coefficients) const {
    const std::size_t level = level_of(function);
    if (level == 0) return value;
    return value - evaluate(positions_[function], normals_[function], objects_[function], coefficients, level - 1);
}

template <class Value>
std::vector<Value> MultilevelBasis::project(const std::vector<Value>& values, const std::vector<char>& active) const {
    require(values.size() == size(), "values: there are ", values.size(), ", wanted ", size());
    require(active.empty() || active.size() == size(), "active: there are ", active.size(), ", wanted ", size(),
            " or none");
    std::vector<Value> coefficients(size());
    for (std::size_t level = 0; level < levels(); ++level)
        parallel_for(first_[level + 1] - first_[level], grain, [&](std::size_t k) {
            const auto j = static_cast<std::uint32_t>(first_[level] + k);
            if (active.empty() || active[j]) coefficients[j] = coefficient(j, values[j], coefficients);
        });
    return coefficients;
}

template <class Value>
MultilevelBasis::Dropped MultilevelBasis::drop(std::vector<Value>& coefficients, double threshold) const {
    require(coefficients.size() == size(), "coefficients: there are ", coefficients.size(), ", wanted ", size());
    require(threshold >= 0.0, "threshold: got ", threshold, ", wanted at least 0");
    Dropped dropped{0, 0.0};
    for (std::size_t level = 0; level < levels(); ++level) {
        double largest = 0.0;
        for (std::uint32_t j = first_[level]; j < first_[level + 1]; ++j) {
            const double size_of = magnitude(coefficients[j]);
            if (!(size_of < threshold) || size_of == 0.0) continue;
            largest = std::max(largest, size_of);
            coefficients[j] = Value{};
            ++dropped.count;
        }
        dropped.bound += largest;
    }
    return dropped;
}

#define SURFLUX_BASIS_OF(Value)                                                                                      \
    template Value MultilevelBasis::evaluate(const Vec3&, const Vec3&, std::uint32_t, const std::vector<Value>&,     \
                                             std::size_t) const;                                                     \
    template std::vector<Value> MultilevelBasis::evaluate(const std::vector<Vec3>&, const std::vector<Vec3>&,        \
                                                          const std::vector<std::uint32_t>&,                         \
                                                          const std::vector<Value>&, std::size_t) const;             \
    template std::vector<Value> MultilevelBasis::project(const std::vector<Value>&, const std::vector<char>&) const; \
    template Value MultilevelBasis::coefficient(std::uint32_t, const Value&, const std::vector<Value>&) const;       \
    template MultilevelBasis::Dropped MultilevelBasis::drop(std::vector<Value>&, double) const;

SURFLUX_BASIS_OF(double)
SURFLUX_BASIS_OF(Rgb)
#undef SURFLUX_BASIS_OF

}  // namespace surflux
