#include "surflux/meshless/support_radii.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/span.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr std::size_t few_times = 4;  // how many times more are looked at, where too few face a compatible way
constexpr std::size_t many = 300;     // beyond which all are: a sorted list gets slow

// The points of one object, by place.
class Places {
public:
    Places(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, Span<std::uint32_t> members)
        : places_(distinct_places(gathered(positions, members))), index_(places_.places) {
        first_.assign(places_.places.size() + 1, 0);
        for (const std::uint32_t place : places_.of_point) ++first_[place + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        normals_.resize(members.size());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::size_t m = 0; m < members.size(); ++m)
            normals_[next[places_.of_point[m]]++] = normals[members.begin()[m]];
    }

    std::vector<Vec3> of_members() const {
        std::vector<Vec3> out;
        out.reserve(places_.of_point.size());
        for (const std::uint32_t place : places_.of_point) out.push_back(places_.places[place]);
        return out;
    }
    // Of the m-th member. `found` and `distances` are scratch memory.
    double radius(std::size_t m, const Vec3& normal, const SupportOptions& options, std::vector<Neighbor>& found,
                  std::vector<double>& distances) const {
        const std::uint32_t own = places_.of_point[m];
        const Vec3& from = places_.places[own];
        const auto wanted = static_cast<std::size_t>(options.neighbors);
        for (std::size_t count = wanted + 1; count <= std::max(many, wanted + 1); count *= few_times) {
            index_.nearest(from, count, found, options.largest_radius);
            std::size_t compatible = 0;
            for (const Neighbor& other : found)
                if (other.index != own && faces(other.index, normal) && ++compatible == wanted) return other.distance;
            if (found.size() < count && found.size() < index_.size()) return options.largest_radius;
            if (count >= index_.size()) break;
        }
        distances.clear();
        for (std::uint32_t place = 0; place < places_.places.size(); ++place)
            if (place != own && faces(place, normal)) distances.push_back(length(places_.places[place] - from));
        if (distances.size() < wanted && std::isfinite(options.largest_radius)) return options.largest_radius;
        if (distances.empty()) return 0.0;
        const std::size_t last = std::min(wanted, distances.size()) - 1;
        std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(last), distances.end());
        const double scale = std::sqrt(static_cast<double>(wanted) / static_cast<double>(last + 1));
        return std::min(scale * distances[last], options.largest_radius);
    }

private:
    static std::vector<Vec3> gathered(const std::vector<Vec3>& positions, Span<std::uint32_t> members) {
        std::vector<Vec3> out;
        out.reserve(members.size());
        for (const std::uint32_t j : members) out.push_back(positions[j]);
        return out;
    }
    bool faces(std::uint32_t place, const Vec3& normal) const {
        return std::any_of(normals_.begin() + first_[place], normals_.begin() + first_[place + 1],
                           [&](const Vec3& n) { return dot(n, normal) > 0.0; });
    }

    DistinctPlaces places_;
    PointIndex index_;
    std::vector<std::uint32_t> first_;  // of a place in normals_
    std::vector<Vec3> normals_;
};

}  // namespace

std::vector<double> support_radii(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<std::uint32_t>& objects, const SupportOptions& options) {
    if (!options.radii.empty()) return options.radii;
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return objects[a] < objects[b]; });
    std::vector<double> radii(positions.size());
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        while (end < order.size() && objects[order[end]] == objects[order[begin]]) ++end;
        const Span<std::uint32_t> members(order.data() + begin, order.data() + end);
        SupportOptions own = options;
        if (!options.largest_radii.empty()) own.largest_radius = options.largest_radii[objects[order[begin]]];
        const Places places(positions, normals, members);
        const std::vector<std::uint32_t> along = morton_order(places.of_members());
        parallel_blocks(members.size(), 512, [&](std::size_t first, std::size_t last) {
            std::vector<Neighbor> found;
            std::vector<double> distances;
            for (std::size_t k = first; k < last; ++k) {
                const std::uint32_t m = along[k], j = members.begin()[m];
                radii[j] = places.radius(m, normals[j], own, found, distances);
            }
        });
    }
    return radii;
}

}  // namespace surflux
