#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/span.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/gathering.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/solution/interpolation.h"
#include "surflux/solution/linear.h"

namespace surflux {

// The linear system of light on a cut, x = G (E + rho (H0 + f + P x)): x is what comes to its nodes from surfels that
// reflect or glow, f what their rays bring of emitters and of the sky, P the weights of nodes at leaves, and G the
// gathering, from whatever node of the tree each ray met.
class GatheredSystem {
public:
    GatheredSystem(const SurfelTree& tree, const Gathering& gathering, const LitPoints& sources, bool emitters_apart,
                   std::size_t channels);

    // Each leaf takes the value of its node; or that of the nodes around by the weights of an interpolation.
    void take_by_nodes(const Cut& cut);
    // Objects by point; `x` as it is, for nodes of which the light differs are asked whether they see each other.
    // Leaves that are not `wanted` take the values of their nodes; none given: all are.
    void interpolate(const Cut& cut, const NodalField& nodes, const std::vector<std::uint32_t>& objects,
                     const std::vector<double>& x, const Sight& sight, const std::vector<char>& wanted = {},
                     const Progress& progress = {});

    // What surfaces send each other, less what escapes and what backs absorb, over what the rows give them of it: 1 but
    // for the noise of the rays and what interpolation cuts off; for what all nodes send with x.
    double balance(const std::vector<double>& x);
    // What is gathered counts as many times.
    void set_gain(double gain) { gain_ = gain; }
    // `x` holds the start and the result.
    LinearReport solve(double tolerance, int max_applications, std::vector<double>& x, const Progress& progress = {});
    // The weights of the nodes at a leaf.
    Span<Interpolation::Weight> weights(std::uint32_t leaf) const {
        return {weights_.data() + begin_[leaf], weights_.data() + begin_[leaf + 1]};
    }
    // All that comes to a point by the weights.
    Rgb irradiance(std::uint32_t point, const std::vector<double>& x) const;
    // What all nodes send, for x as it is.
    const std::vector<double>& sent(const std::vector<double>& x);

    std::size_t channels() const { return channels_; }
    Rgb unpack(const double* in) const { return channels_ == 1 ? Rgb{in[0], in[0], in[0]} : Rgb{in[0], in[1], in[2]}; }
    Rgb value(const std::vector<double>& x, std::size_t place) const { return unpack(&x[place * channels_]); }
    // What rays of a node find of emitters and of the sky.
    Rgb found(std::size_t place) const;

private:
    void send(const std::vector<double>& x, bool with_sources);
    void gather(std::vector<double>& out) const;

    const SurfelTree& tree_;
    const Gathering& gathering_;
    const LitPoints& sources_;
    const bool emitters_apart_;
    const std::size_t channels_;
    const Cut* cut_ = nullptr;
    double gain_ = 1.0;
    std::vector<std::size_t> begin_;  // of each point, in weights_
    std::vector<Interpolation::Weight> weights_;
    std::vector<double> sent_;
};

}  // namespace surflux
