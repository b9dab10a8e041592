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
    std::map<std::pair<Key, Key>, std::uint32_t> edge_of;
    DisjointSets facets(pieces.size());
    const auto corners = [&](std::size_t k) {
        const Triangle& t = pieces[k].triangle;
        return std::array<Vec3, 4>{t.a, t.b, t.c, t.a};
    };
    for (std::uint32_t k = 0; k < pieces.size(); ++k) {
        const std::array<Vec3, 4> c = corners(k);
        for (int e = 0; e < 3; ++e) edge_of.emplace(std::pair{key_of(c[e]), key_of(c[e + 1])}, k);
    }
    const auto neighbour = [&](std::uint32_t k, const Vec3& from, const Vec3& to) {
        const auto found = edge_of.find({key_of(to), key_of(from)});
        if (found == edge_of.end()) return k;
        const Piece &a = pieces[k], &b = pieces[found->second];
        return a.group == b.group && a.exitance == b.exitance && dot(a.normal, b.normal) > parallel ? found->second : k;
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
            triangles_.push_back(pieces[k].triangle);
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

Rgb EmissiveFacets::irradiance(int group, const Vec3& point, const Vec3& normal) const {
    Rgb out;
    const auto g = static_cast<std::size_t>(group);
    for (std::uint32_t f = first_of_group_[g]; f < first_of_group_[g + 1]; ++f)
        out += form_factor(facets_[f], point, normal) * facets_[f].exitance;
    return out;
}

double EmissiveFacets::form_factor(const Vec3& point, const Vec3& normal) const {
    double out = 0.0;
    for (const Facet& facet : facets_) out += form_factor(facet, point, normal);
    return out;
}

double EmissiveFacets::form_factor(const Facet& facet, const Vec3& point, const Vec3& normal) const {
    if (!(dot(facet.normal, point - facet.on_it) > 0.0)) return 0.0;
    double lowest = 0.0, highest = 0.0, sum = 0.0;
    for (std::uint32_t e = facet.edges; e < facet.edges_end; ++e) {
        const double height = dot(normal, edges_[e].from - point);
        lowest = std::min(lowest, height), highest = std::max(highest, height);
    }
    if (!(highest > 0.0)) return 0.0;
    if (lowest < 0.0) {  // the horizon cuts it
        for (std::uint32_t t = facet.triangles; t < facet.triangles_end; ++t) {
            const Vec3 corners[] = {triangles_[t].a, triangles_[t].b, triangles_[t].c};
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
