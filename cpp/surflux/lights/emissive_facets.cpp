#include "surflux/lights/emissive_facets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"

namespace surflux {

namespace {

constexpr double parallel = 1.0 - 1e-8;  // cosine of an angle that floats of a flat mesh may have
constexpr double straight = 1e-9;        // sine, of edges that go on

using Key = std::array<double, 3>;
Key key_of(const Vec3& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

}  // namespace

EmissiveFacets::EmissiveFacets(const std::vector<Piece>& pieces, int groups) {
    // The edge of a triangle and that of its neighbour are one, the other way round.
    std::map<std::pair<Key, Key>, std::vector<std::uint32_t>> edges_of;
    DisjointSets facets(pieces.size());
    const auto corners = [&](std::size_t k) {
        const Triangle& t = pieces[k].triangle;
        return std::array<Vec3, 4>{t.a, t.b, t.c, t.a};
    };
    for (std::uint32_t k = 0; k < pieces.size(); ++k) {
        const std::array<Vec3, 4> c = corners(k);
        for (int e = 0; e < 3; ++e) edges_of[{key_of(c[e]), key_of(c[e + 1])}].push_back(k);
    }
    // The only piece alike along an edge, or none: of pieces in one place it could not be told which goes on where.
    constexpr std::uint32_t none = 0xffffffffu;
    const auto only = [&](std::uint32_t k, const Vec3& from, const Vec3& to) {
        std::uint32_t out = none;
        const auto found = edges_of.find({key_of(from), key_of(to)});
        if (found == edges_of.end()) return none;
        for (const std::uint32_t other : found->second) {
            const Piece &a = pieces[k], &b = pieces[other];
            if (a.group != b.group || !(a.exitance == b.exitance) || !(dot(a.normal, b.normal) > parallel)) continue;
            if (out != none) return none;
            out = other;
        }
        return out;
    };
    const auto neighbour = [&](std::uint32_t k, const Vec3& from, const Vec3& to) {
        const std::uint32_t other = only(k, from, to) == k ? only(k, to, from) : none;
        return other == none ? k : other;
    };
    for (std::uint32_t k = 0; k < pieces.size(); ++k) {
        const std::array<Vec3, 4> c = corners(k);
        for (int e = 0; e < 3; ++e) facets.join(k, neighbour(k, c[e], c[e + 1]));
    }
    const std::vector<std::uint32_t> facet_of = facets.numbered(pieces.size());
    const std::uint32_t count = pieces.empty() ? 0 : 1 + *std::max_element(facet_of.begin(), facet_of.end());
    std::vector<std::vector<std::uint32_t>> members(count);
    for (std::uint32_t k = 0; k < pieces.size(); ++k) members[facet_of[k]].push_back(k);
    std::stable_sort(members.begin(), members.end(),
                     [&](const auto& a, const auto& b) { return pieces[a.front()].group < pieces[b.front()].group; });

    first_of_group_.assign(static_cast<std::size_t>(groups) + 1, 0);
    for (const std::vector<std::uint32_t>& of : members) {
        const Piece& first = pieces[of.front()];
        Facet facet{first.normal,
                    first.triangle.a,
                    first.exitance,
                    static_cast<std::uint32_t>(edges_.size()),
                    0,
                    static_cast<std::uint32_t>(triangles_.size()),
                    0};
        std::map<Key, Edge> border;  // by where an edge begins
        bool is_simple = true;
        std::vector<Edge> all;
        for (const std::uint32_t k : of) {
            const std::array<Vec3, 4> c = corners(k);
            for (int e = 0; e < 3; ++e) {
                if (neighbour(k, c[e], c[e + 1]) != k) continue;
                all.push_back({c[e], c[e + 1]});
                is_simple = border.emplace(key_of(c[e]), all.back()).second && is_simple;
            }
            facet.area += area_of(pieces[k].triangle);
            triangles_.push_back({pieces[k].triangle, pieces[k].surfel, facet.area});
        }
        // Edges that go straight on are one.
        if (is_simple) {
            for (auto at = border.begin(); at != border.end(); ++at) {
                for (auto next = border.find(key_of(at->second.to)); next != border.end() && next != at;
                     next = border.find(key_of(at->second.to))) {
                    const Vec3 a = at->second.to - at->second.from, b = next->second.to - next->second.from;
                    if (!(dot(a, b) > 0.0 && length(cross(a, b)) < straight * length(a) * length(b))) break;
                    at->second.to = next->second.to;
                    border.erase(next);
                }
            }
            all.clear();
            for (const auto& [_, edge] : border) all.push_back(edge);
        }
        edges_.insert(edges_.end(), all.begin(), all.end());
        facet.edges_end = static_cast<std::uint32_t>(edges_.size());
        facet.triangles_end = static_cast<std::uint32_t>(triangles_.size());
        facets_.push_back(facet);
        ++first_of_group_[static_cast<std::size_t>(first.group) + 1];
    }
    for (std::size_t g = 1; g < first_of_group_.size(); ++g) first_of_group_[g] += first_of_group_[g - 1];
}

EmissiveFacets::Sample EmissiveFacets::sample(std::uint32_t facet, double u, double v) const {
    const Facet& f = facets_[facet];
    const Part *part = &triangles_[f.triangles], *last = &triangles_[f.triangles_end - 1];
    u *= f.area;
    part = std::upper_bound(part, last, u, [](double at, const Part& of) { return at < of.up_to; });
    const double area = area_of(part->triangle);
    const Vec3 w = square_to_triangle(std::clamp((u - (part->up_to - area)) / area, 0.0, 1.0), v);
    return {w.x * part->triangle.a + w.y * part->triangle.b + w.z * part->triangle.c, part->surfel};
}

Rgb EmissiveFacets::irradiance(std::uint32_t facet, const Sample& sample, const Vec3& point, const Vec3& normal) const {
    const Vec3 d = sample.place - point;
    const double squared = length_squared(d), up = dot(normal, d), facing = -dot(facets_[facet].normal, d);
    if (!(up > 0.0 && facing > 0.0)) return {};
    return (facets_[facet].area * up * facing / (pi * squared * squared)) * facets_[facet].exitance;
}

double EmissiveFacets::form_factor(const Vec3& point, const Vec3& normal) const {
    double out = 0.0;
    for (const Facet& facet : facets_) out += form_factor(facet, point, normal);
    return out;
}

double EmissiveFacets::form_factor(const Facet& facet, const Vec3& point, const Vec3& normal) const {
    const double tolerance = no_height(point, facet.on_it, std::sqrt(facet.area));
    if (!(dot(facet.normal, point - facet.on_it) > tolerance)) return 0.0;
    double lowest = 0.0, highest = 0.0, sum = 0.0;
    for (std::uint32_t e = facet.edges; e < facet.edges_end; ++e) {
        const double height = dot(normal, edges_[e].from - point);
        lowest = std::min(lowest, height), highest = std::max(highest, height);
    }
    if (!(highest > 0.0)) return 0.0;
    if (lowest < 0.0) {  // the horizon cuts it
        for (std::uint32_t t = facet.triangles; t < facet.triangles_end; ++t) {
            const Triangle& of = triangles_[t].triangle;
            const Vec3 corners[] = {of.a, of.b, of.c};
            sum += element_to_polygon(point, normal, corners, 3);
        }
        return sum;
    }
    for (std::uint32_t e = facet.edges; e < facet.edges_end; ++e) {
        const Vec3 a = edges_[e].from - point, b = edges_[e].to - point, axis = cross(a, b);
        const double sine = length(axis);
        if (sine > 0.0) sum += std::atan2(sine, dot(a, b)) / sine * dot(axis, normal);
    }
    return std::abs(sum) / (2.0 * pi);
}

}  // namespace surflux
