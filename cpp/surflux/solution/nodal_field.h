#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/span.h"
#include "surflux/core/vec.h"
#include "surflux/solution/interpolation_matrix.h"
#include "surflux/solution/sight.h"
#include "surflux/solution/tuning.h"

namespace surflux {

// Irradiance at a place with its rotation gradient (Ward and Heckbert 1992): for normals n' around its own it is value
// + n' . (u frame.u + v frame.v). The same light from everywhere, below the horizon too, has no gradient.
struct TiltedRgb {
    Rgb value, u, v;
};

// First-order Shepard interpolation of irradiance from nodes: each node's value is extrapolated by its translation
// gradient, fitted to its neighbours by least squares (Franke and Nielson 1980), and, where known, by its rotation
// gradient to the normal asked for (Ward and Heckbert 1992); Interpolation's partition of unity blends them.
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

    NodalField(std::vector<Vec3> positions, std::vector<Vec3> normals, std::vector<std::uint32_t> objects,
               const Progress& progress = {}, const NodalTuning& tuning = {});
    NodalField(const NodalField&) = delete;  // nor moved: the interpolation refers to the positions and normals
    NodalField& operator=(const NodalField&) = delete;

    std::size_t size() const { return positions_.size(); }
    const Interpolation& interpolation() const { return *interpolation_; }
    const std::vector<Vec3>& positions() const { return positions_; }
    const std::vector<Vec3>& normals() const { return normals_; }
    const std::vector<std::uint32_t>& objects() const { return objects_; }
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
        InterpolationMatrix::Row weights;
    };
    // The field at all places of a surface, conserving the integral of zeroth-order interpolation: what gradients add
    // around a node is taken off there. They are limited to twice of what weights say and to half of it
    // (`most_sloped`), so that the factors of nodes are between 1/2 and 2, too. By the limits of at() alone, which may
    // be nothing all around a node in the dark, those would have no bound. `place` is asked on many threads at once.
    std::vector<Rgb> at_conservatively(const Values& field, std::size_t places,
                                       const std::function<Place(std::size_t)>& place,
                                       const Progress& progress = {}) const;

private:
    void fit_slopes(Values& field, const Sight* sight, const Progress& progress) const;
    Rgb turned(const Values& field, std::uint32_t k, const Vec3& normal) const;

    std::vector<Vec3> positions_, normals_;
    std::vector<std::uint32_t> objects_;
    std::vector<Frame> frames_;
    std::unique_ptr<Interpolation> interpolation_;
    std::unique_ptr<Sight::Sites> sites_;
    NodalTuning tuning_;
};

}  // namespace surflux
