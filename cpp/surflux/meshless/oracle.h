#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "surflux/meshless/meshless_field.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/tuning.h"

namespace surflux {

// Irradiance of receivers, by row.
struct Received {
    std::vector<Rgb> values;        // the solution
    std::vector<Rgb> direct;        // the part that is direct light
    std::vector<Rgb> unbounced;     // that and emission
    std::vector<Rgb> first_bounce;  // of the light that is not in the basis
};

// RECEIVER-ORACLE of L07 6.3, the refinement criterion: around which receivers the next level gets points. On the
// coarsest level around those that differ from others nearby; on finer ones, where a coefficient is the correction of
// coarser levels, around those whose coefficient is large. What surfaces send is measured by its own RMS, beside all
// that is in the basis: a bright sky on the outside hides no room. Holds references alone, made for one question.
struct Oracle {
    const MultilevelBasis& basis;
    const Receivers& receivers;
    const std::vector<double>& noise;         // standard error of each row
    const std::vector<double>& first_radius;  // of each object's points on the coarsest level
    std::uint32_t evenly_placed;              // so many of them are as dense all over an object; others are of nooks
    const Received& rows;
    const MeshlessField& field;  // coefficients of the solution and of its direct light
    const MeshlessTuning& tuning;
    double beside;  // RMS over the surface of light that is not in the basis: beside it rounding is no light

    // The functions of a level whose difference or coefficient, of all light or of what surfaces send, exceeds by
    // tuning.significance standard errors the larger of wanted() and tuning.own_share times epsilon_e of their own
    // light, both times allowed_at().
    std::vector<std::uint32_t> refined(std::size_t level, double epsilon_e) const;

    // What the light may be off by on the coarsest level: of all light, and of what surfaces send. In the dim parts
    // of a scene that is a share of the light there, down to tuning.dimmest of the RMS of all.
    struct Wanted {
        double of_all, of_sent;
        double local, dimmest;

        Wanted at(double light) const;
        double where_dim(double light) const { return local * std::max(light, dimmest); }
        Wanted times(double more) const { return {more * of_all, more * of_sent, more * local, dimmest}; }
    };
    Wanted wanted(double epsilon_e) const;
    // How much more it may be off on a level.
    static double allowed_at(double level);
};

}  // namespace surflux
