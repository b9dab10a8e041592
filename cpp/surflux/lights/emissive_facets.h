#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Emissive patches in closed form: those beside each other in one plane, of one exitance, are one facet. By Lambert's
// formula its form factor is a sum over its border alone, so that it does not matter how finely a lamp is cut.
class EmissiveFacets {
public:
    struct Piece {
        Triangle triangle;
        Vec3 normal;  // unit, of its front
        Rgb exitance;
        int group;
    };
    EmissiveFacets(const std::vector<Piece>& pieces, int groups);

    // Edges along borders: what irradiance() costs.
    std::size_t edges() const { return edges_.size(); }
    // What a group brings to a point if nothing stands between.
    Rgb irradiance(int group, const Vec3& point, const Vec3& normal) const;
    // Of all groups, with an exitance of 1.
    double form_factor(const Vec3& point, const Vec3& normal) const;

private:
    struct Edge {
        Vec3 from, to;
    };
    struct Facet {
        Vec3 normal, on_it;
        Rgb exitance;
        std::uint32_t edges, edges_end;  // of edges_
        std::uint32_t triangles, triangles_end;
    };
    double form_factor(const Facet& facet, const Vec3& point, const Vec3& normal) const;

    std::vector<Edge> edges_;
    std::vector<Triangle> triangles_;
    std::vector<Facet> facets_;                  // by group
    std::vector<std::uint32_t> first_of_group_;  // and the end
};

}  // namespace surflux
