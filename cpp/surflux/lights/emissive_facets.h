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
        std::uint32_t surfel;
        int group;
    };
    EmissiveFacets(const std::vector<Piece>& pieces, int groups);

    // Edges along borders: what irradiance() costs.
    std::size_t edges() const { return edges_.size(); }
    // Facets of a group are these, from the first to before the end.
    std::uint32_t first_of(int group) const { return first_of_group_[static_cast<std::size_t>(group)]; }
    std::uint32_t end_of(int group) const { return first_of_group_[static_cast<std::size_t>(group) + 1]; }
    // What a facet brings to a point if nothing stands between.
    Rgb irradiance(std::uint32_t facet, const Vec3& point, const Vec3& normal) const {
        return form_factor(facets_[facet], point, normal) * facets_[facet].exitance;
    }
    // Of all of them, with an exitance of 1.
    double form_factor(const Vec3& point, const Vec3& normal) const;

    // A point of a facet, uniform by area, (u, v) in [0, 1).
    struct Sample {
        Vec3 place;
        std::uint32_t surfel;
    };
    Sample sample(std::uint32_t facet, double u, double v) const;
    // What it brings as the mean over the facet.
    Rgb irradiance(std::uint32_t facet, const Sample& sample, const Vec3& point, const Vec3& normal) const;

private:
    struct Edge {
        Vec3 from, to;
    };
    struct Facet {
        Vec3 normal, on_it;
        Rgb exitance;
        std::uint32_t edges, edges_end;          // of edges_
        std::uint32_t triangles, triangles_end;  // of triangles_
        double area = 0.0;
    };
    struct Part {
        Triangle triangle;
        std::uint32_t surfel;
        double up_to;  // area of those of the facet up to and with it
    };
    double form_factor(const Facet& facet, const Vec3& point, const Vec3& normal) const;

    std::vector<Edge> edges_;
    std::vector<Part> triangles_;
    std::vector<Facet> facets_;                  // by group
    std::vector<std::uint32_t> first_of_group_;  // and the end
};

}  // namespace surflux
