#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/span.h"
#include "surflux/core/vec.h"
#include "surflux/solution/interpolation.h"
#include "surflux/solution/sight.h"

namespace surflux {

// Irradiance at a place for normals n' around its own, to first order: value + n' . (u frame.u + v frame.v). So the
// same light from everywhere, below the horizon too, is the same for all normals.
struct TiltedRgb {
    Rgb value, u, v;
};

// A field on surfaces from its values at nodes: each is continued linearly by the slope that its neighbours give
// (Franke and Nielson 1980) and, where it is known how the field turns with the normal, to the normal asked for (Ward
// and Heckbert 1992); Shepard's weights blend them.
class NodalField {
public:
    struct Slope {
        Rgb u, v;
    };
    // One of any number of fields over the same nodes.
    struct Values {
        std::vector<TiltedRgb> values;
        std::vector<Slope> slopes;
        bool tilted = true;
    };

    NodalField(std::vector<Vec3> positions, std::vector<Vec3> normals, std::vector<std::uint32_t> objects);
    NodalField(const NodalField&) = delete;  // nor moved: the interpolation refers to the positions and normals
    NodalField& operator=(const NodalField&) = delete;

    std::size_t size() const { return positions_.size(); }
    const Interpolation& interpolation() const { return *interpolation_; }
    const std::vector<Vec3>& positions() const { return positions_; }
    const std::vector<Vec3>& normals() const { return normals_; }
    // Nodes as sites of the scene's Sight: of one scene, always the same.
    const Sight::Sites& sites() const { return *sites_; }
    // Slopes of a node come from those that it is joined with, as far as `sight` is given.
    Values fit(std::vector<TiltedRgb> values, const Sight* sight = nullptr, const Progress& progress = {}) const;
    // Of values that do not say how they turn.
    Values fit(const std::vector<Rgb>& values, const Sight* sight = nullptr, const Progress& progress = {}) const;
    Rgb at(const Values& field, const Vec3& point, const Vec3& normal, Span<Interpolation::Weight> weights) const;

    struct Place {
        Vec3 position, normal;
        double area;
        Span<Interpolation::Weight> weights;
    };
    // The field at all places of a surface, with the integral of values and weights alone: what slopes and turns add
    // around a node is taken off there. They are limited to twice of what weights say and to half of it, so that the
    // factors of nodes are between 1/2 and 2, too. By the limits of at() alone, which may be nothing all around a node
    // in the dark, those would have no bound.
    std::vector<Rgb> at_conservatively(const Values& field, const std::vector<Place>& places) const;

private:
    void fit_slopes(Values& field, const Sight* sight, const Progress& progress) const;
    Rgb turned(const Values& field, std::uint32_t k, const Vec3& normal) const;

    std::vector<Vec3> positions_, normals_;
    std::vector<std::uint32_t> objects_;
    std::vector<Frame> frames_;
    std::unique_ptr<Interpolation> interpolation_;
    std::unique_ptr<Sight::Sites> sites_;
};

}  // namespace surflux
