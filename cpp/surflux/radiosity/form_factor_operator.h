#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/radiosity/row_block.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

struct FormFactorOperatorOptions {
    int rays = 256;  // per surfel
    std::uint64_t seed = 0;
    Team team = {};
};

// Form factors K of all pairs, for any number of surfels: a sparse matrix of rays' ends, never of pairs. Rays of i that
// met j and rays of j that met i are two estimates of one exchange, A_i K_ij = A_j K_ji. Together, each weighted by its
// inverse variance, c rays either way give
//   A_i K_ij = d_i d_j (c_ij + c_ji) / (n_i / A_i + n_j / A_j),
// which is symmetric. d is the diagonal with which each row, with what its rays say escapes and meets backs, makes 1
// (symmetric_scaling.h): 1 but for the variance of the counts, which it takes out of the light of a uniform furnace.
class FormFactorOperator {
public:
    // What it is made of; `scale` is d.
    struct State {
        RowBlock rows;
        std::vector<double> areas, scale;
        // Shares of each row: what leaves the scene, and what meets backs or finds no symmetric exchange.
        std::vector<double> escape, absorbed;
    };
    explicit FormFactorOperator(State state);

    std::size_t size() const { return state_.areas.size(); }
    const State& state() const { return state_; }

    // out = K x, of `channels` interleaved channels.
    void apply(const std::vector<double>& x, std::size_t channels, std::vector<double>& out) const;
    // out = K^T x.
    void apply_transposed(const std::vector<double>& x, std::size_t channels, std::vector<double>& out) const;
    // Variance of K x in one channel by that of the counts, which are Poisson's around the mean of their row.
    std::vector<double> variance(const std::vector<double>& x) const;

private:
    State state_;
    std::vector<double> density_;  // n_i / A_i
};

// The scene needs areas.
FormFactorOperator form_factor_operator(const CompiledScene& compiled, const FormFactorOperatorOptions& options,
                                        const StageProgress& progress = {});

}  // namespace surflux
