#include "surflux/solution/interpolation.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr std::size_t few = 20, many = 120;  // looked at, to find as many that face the point's way
constexpr double least_cosine = 0.5;         // between normals
constexpr std::size_t large = 1 << 16;       // sites of an object
constexpr double tied = 1e-9;                // relative difference of distances
constexpr double off_surface = 8.0;          // how many times the squared distance off the surface counts

}  // namespace

struct Interpolation::Object {
    std::vector<std::uint32_t> sites;
    std::vector<Vec3> points;
    Vec3 low, high;
    std::unique_ptr<PointIndex> index;

    double distance_to(const Vec3& p) const {
        double squared = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double outside = std::max({low[axis] - p[axis], p[axis] - high[axis], 0.0});
            squared += outside * outside;
        }
        return std::sqrt(squared);
    }
};

Interpolation::~Interpolation() = default;

Interpolation::Interpolation(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                             const std::vector<std::uint32_t>& objects, const Progress& progress)
    : positions_(positions), normals_(normals) {
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (objects[i] >= place_.size()) place_.resize(objects[i] + 1, any_object);
        std::uint32_t& place = place_[objects[i]];
        if (place == any_object) {
            place = static_cast<std::uint32_t>(objects_.size());
            objects_.emplace_back();
            objects_.back().low = objects_.back().high = positions[i];
        }
        Object& object = objects_[place];
        object.sites.push_back(i);
        object.points.push_back(positions[i]);
        for (int axis = 0; axis < 3; ++axis) {
            object.low[axis] = std::min(object.low[axis], positions[i][axis]);
            object.high[axis] = std::max(object.high[axis], positions[i][axis]);
        }
    }
    // Few large ones report while they are built, many small ones are built side by side.
    const auto is_large = [](const Object& object) { return object.points.size() > large; };
    for (Object& object : objects_)
        if (is_large(object)) object.index = std::make_unique<PointIndex>(object.points, progress);
    const auto build_small = [&](std::size_t k) {
        if (!is_large(objects_[k])) objects_[k].index = std::make_unique<PointIndex>(objects_[k].points);
    };
    parallel_for(objects_.size(), 1, build_small, progress);
}

void Interpolation::nearest(const Vec3& point, const Vec3& normal, std::uint32_t object, std::size_t count,
                            std::vector<Weight>& out) const {
    thread_local std::vector<Neighbor> found;
    out.clear();
    if (object == any_object) {
        double least = std::numeric_limits<double>::infinity();
        std::vector<Weight> candidate;
        for (std::uint32_t number = 0; number < place_.size(); ++number) {
            if (place_[number] == any_object || objects_[place_[number]].distance_to(point) >= least) continue;
            nearest(point, normal, number, count, candidate);
            if (candidate.empty() || candidate[0].weight >= least) continue;
            least = candidate[0].weight;
            out = candidate;
        }
        return;
    }
    if (object >= place_.size() || place_[object] == any_object) return;
    const Object& of = objects_[place_[object]];
    for (const std::size_t looked_at : {few, many}) {
        of.index->nearest(point, looked_at, found);
        out.clear();
        for (const Neighbor& neighbor : found) {
            const std::uint32_t site = of.sites[neighbor.index];
            const double cosine = dot(normal, normals_[site]);
            if (cosine <= least_cosine) continue;
            const Vec3 d = positions_[site] - point;
            const double off = std::max(std::abs(dot(d, normal)), std::abs(dot(d, normals_[site])));
            out.push_back({site, std::sqrt(length_squared(d) + off_surface * off * off)});
        }
        if (out.size() >= std::min(count, of.sites.size()) || looked_at >= of.sites.size()) break;
    }
    std::sort(out.begin(), out.end(), [](const Weight& a, const Weight& b) {
        return a.weight < b.weight || (a.weight == b.weight && a.site < b.site);
    });
    if (out.size() > count) out.resize(count);
}

void Interpolation::at(const Vec3& point, const Vec3& normal, std::uint32_t object, std::vector<Weight>& out) const {
    nearest(point, normal, object, most_sites, out);
    if (out.empty()) {
        // Nothing faces its way: whatever is nearest.
        thread_local std::vector<Neighbor> found;
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t number = 0; number < place_.size(); ++number) {
            if (place_[number] == any_object || (object != any_object && number != object)) continue;
            const Object& of = objects_[place_[number]];
            if (of.distance_to(point) >= least) continue;
            of.index->nearest(point, 1, found);
            if (found[0].distance >= least) continue;
            least = found[0].distance;
            out.assign(1, {of.sites[found[0].index], 1.0});
        }
        return;
    }
    double h = out.size() == most_sites ? out.back().weight : 1.5 * out.back().weight;
    // Where others are as far as the last, as around a corner of equal patches, they count as they do beside it.
    if (out.size() == most_sites && out[most_sites - 2].weight > (1.0 - tied) * h) h *= 1.0 + tied;
    double sum = 0.0;
    for (Weight& w : out) {
        const double d = w.weight;
        if (d <= 1e-6 * h) {
            const std::uint32_t site = w.site;
            out.assign(1, {site, 1.0});
            return;
        }
        const double cosine = dot(normal, normals_[w.site]);
        const double facing = (cosine - least_cosine) / (1.0 - least_cosine);
        const double root = std::max(0.0, h - d) / (h * d);
        sum += w.weight = facing * facing * root * root;
    }
    if (!(sum > 0.0)) {
        const std::uint32_t site = out[0].site;
        out.assign(1, {site, 1.0});
        return;
    }
    for (Weight& w : out) w.weight /= sum;
}

}  // namespace surflux
