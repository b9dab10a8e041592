#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/gathering.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/solution/interpolation_matrix.h"
#include "surflux/solution/linear.h"
#include "surflux/solution/power_balance.h"
#include "surflux/solution/reciprocal_scaling.h"

namespace surflux {

// The linear system of light on a cut, x = G (E + rho (H0 + P (x + f))): x is the irradiance of its nodes from surfels,
// f that from the sky by their rays, P the interpolation from nodes to leaves, H0 the irradiance of leaves that needs
// no solving (LitPoints), and G the gathering, from whatever node of the tree each ray met. H0 has what emissive
// surfels bring that `emitters` sample: their E is 0 here.
class GatheredSystem {
public:
    GatheredSystem(const SurfelTree& tree, const Gathering& gathering, const LitPoints& sources,
                   const LightSampler& emitters, std::size_t channels, Team team = {});

    // Sets P, the weights that take values at nodes to leaves. First of zeroth order: each leaf has the value of its
    // node.
    void take_by_nodes(const Cut& cut);
    // Then from the nodes around each leaf, but only such as it sees (Sight::keep_joined, which asks about nodes whose
    // light in `x` differs). `objects`: by point. Leaves that are not `wanted` keep the values of their nodes; empty:
    // all are wanted.
    void interpolate(const Cut& cut, const NodalField& nodes, const std::vector<std::uint32_t>& objects,
                     const std::vector<double>& x, const Sight& sight, const std::vector<char>& wanted = {},
                     const Progress& progress = {});

    // Scales rows and senders so that energy is kept (solution/reciprocal_scaling.h): what all receive from a sender is
    // what its own rays say leaves it for fronts of others, for about the light of x. After interpolate().
    ReciprocalScaling scale_by_reciprocity(const std::vector<double>& x, const ReciprocityTuning& tuning = {},
                                           const Progress& progress = {});
    // `x` holds the start and the result. `unit`: the light that places are solved in units of, so that a dim room has
    // a residual as small as a bright one; empty: all the same.
    LinearReport solve(double tolerance, int max_applications, std::vector<double>& x, const std::vector<double>& unit,
                       const Progress& progress = {});
    // The weights of the nodes at a leaf.
    InterpolationMatrix::Row weights(std::uint32_t leaf) const {
        return weights_.empty() ? InterpolationMatrix::Row(cut_->place_of[leaf], 1.0) : weights_[leaf];
    }
    // What of a point's hemisphere leaves the scene, or meets backs, by the weights.
    HemisphereLoss loss(std::uint32_t point) const;
    // The connected part that a point belongs to; before any scaling, all are one.
    std::uint32_t part(std::uint32_t point) const {
        if (part_.empty()) return 0;
        const InterpolationMatrix::Row row = weights(point);
        return row.empty() ? 0 : part_[row.begin()->site];
    }
    // What comes to a point from the sky, interpolated from what rays of the nodes around found.
    Rgb sky(std::uint32_t point) const;
    // All that comes to a point by the weights.
    Rgb irradiance(std::uint32_t point, const std::vector<double>& x) const;
    // Where the power of x went, and the squared luminance of all irradiance by area.
    struct Account {
        PowerBalance power;
        double squared = 0.0, area = 0.0;
    };
    Account account(const std::vector<double>& x, const Progress& progress = {}) const;
    // What all nodes of the tree send for x, scaled as by scale_by_reciprocity().
    const std::vector<double>& sent(const std::vector<double>& x, const Progress& progress = {});
    // The same without the factors of senders, which end here.
    const std::vector<double>& radiosity(const std::vector<double>& x, const Progress& progress = {});

    // Who shares what all rows gather: no one where they are so few that each is done sooner than told of.
    const Team& team() const;

    std::size_t channels() const { return channels_; }
    Rgb unpack(const double* in) const { return channels_ == 1 ? Rgb{in[0], in[0], in[0]} : Rgb{in[0], in[1], in[2]}; }
    Rgb value(const std::vector<double>& x, std::size_t place) const { return unpack(&x[place * channels_]); }
    // Light at nodes, scaled so that all leaves of each connected part receive by it, in each channel, what they do by
    // `as`. After scale_by_reciprocity().
    std::vector<Rgb> keep_power(const std::vector<Rgb>& as, std::vector<Rgb> light) const;
    // What rays of a node find of the sky, scaled as its row is.
    Rgb found(std::size_t place) const { return tilted_sky(place).value; }
    TiltedRgb tilted_sky(std::size_t place) const;

private:
    double row_scale(std::size_t place) const { return row_scale_.empty() ? 1.0 : row_scale_[place]; }
    void send(const std::vector<double>& x, bool with_sources, const Progress& progress);
    // What `sent` of the tree's nodes brings to each row of the cut, by one channel or more.
    void gather(const std::vector<double>& sent, std::size_t channels, std::vector<double>& out) const;
    void find_parts(const Progress& progress);
    void take_off_bias(const std::vector<std::uint32_t>& leaves, RayExchange& exchange, const Progress& progress) const;
    void drop_scaling();

    const SurfelTree& tree_;
    const Gathering& gathering_;
    const LitPoints& sources_;
    const LightSampler& emitters_;
    const std::size_t channels_;
    const Team team_;
    const Cut* cut_ = nullptr;
    std::vector<double> row_scale_, row_area_;  // of places of the cut; empty: 1
    std::vector<double> sender_scale_;          // of points; empty: 1
    std::vector<std::uint32_t> part_;           // connected part of each place of the cut
    InterpolationMatrix weights_;               // of points; empty: each has the value of its node
    std::vector<double> sent_;
};

}  // namespace surflux
