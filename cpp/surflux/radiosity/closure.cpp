#include "surflux/radiosity/closure.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "surflux/solution/conjugate_gradients.h"

namespace surflux {

namespace {

constexpr double largest_scale = 2.0;
constexpr int warm_up_rounds = 3, newton_rounds = 30, newton_applications = 60;
constexpr double newton_tolerance = 0.1, newton_limit = 1.0;

// The state of the iteration: what leaves each surfel at the present scale, and what is known of the exchange.
class Closing {
public:
    Closing(Exchange& exchange, const Hemispheres& hemispheres, const Progress& progress, Closure& closure)
        : exchange_(exchange),
          hemispheres_(hemispheres),
          progress_(progress),
          closure_(closure),
          ones_(exchange.size, 1.0),
          outflow_(exchange.size),
          slope_(exchange.size) {
        exchange.scale.assign(exchange.size, 1.0);
    }

    double row(std::size_t i) const { return outflow_[i] / exchange_.areas[i]; }
    double loss_scale(std::size_t i) const { return std::pow(exchange_.scale[i], exchange_.yields[i]); }
    // Held at the bound: its row lacks something, but its scale must not grow.
    bool held(std::size_t i) const { return exchange_.scale[i] >= largest_scale && row(i) < 1.0; }

    void measure() {
        apply(ones_, product_);
        closure_.residual = 0.0;
        for (std::size_t i = 0; i < exchange_.size; ++i) {
            const double lost =
                loss_scale(i) * exchange_.areas[i] * (hemispheres_.escape[i] + hemispheres_.absorbed[i]);
            outflow_[i] = product_[i] + lost;
            slope_[i] = product_[i] + exchange_.yields[i] * lost;
            if (!held(i)) closure_.residual = std::max(closure_.residual, std::abs(row(i) - 1.0));
        }
    }

    void sinkhorn_round() {
        for (std::size_t i = 0; i < exchange_.size; ++i)
            set_scale(i, row(i) > 0.0 ? exchange_.scale[i] / std::sqrt(row(i)) : largest_scale);
    }

    // In log scale: (DGD + diag(slope)) step = A - outflow over the rows that are not held, with unit diagonal.
    void newton_round() {
        const std::size_t n = exchange_.size;
        std::vector<double> weight(n), right(n), scaled(n), step(n, 0.0);
        for (std::size_t i = 0; i < n; ++i) {
            weight[i] = held(i) ? 0.0 : 1.0 / std::sqrt(slope_[i]);
            right[i] = weight[i] * (exchange_.areas[i] - outflow_[i]);
        }
        const LinearOperator hessian = [&](const std::vector<double>& x, std::vector<double>& out) {
            for (std::size_t i = 0; i < n; ++i) scaled[i] = weight[i] * x[i];
            apply(scaled, out);
            for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + weight[i] * out[i];
        };
        conjugate_gradients(hessian, right, 1, newton_tolerance, newton_applications, step);
        for (std::size_t i = 0; i < n; ++i)
            if (!held(i))
                set_scale(i,
                          exchange_.scale[i] * std::exp(std::clamp(weight[i] * step[i], -newton_limit, newton_limit)));
    }

    // What is left when Newton's method has not settled: symmetric still, and rows at most 1, as yields are.
    void shrink_rows_above_one() {
        for (std::size_t i = 0; i < exchange_.size; ++i)
            if (row(i) > 1.0) exchange_.scale[i] *= std::pow(row(i), -1.0 / exchange_.yields[i]);
    }

private:
    void set_scale(std::size_t i, double value) { exchange_.scale[i] = std::min(value, largest_scale); }

    void apply(const std::vector<double>& x, std::vector<double>& out) {
        exchange_.apply(x, out, 1);
        // How many it takes is not known: most scenes, 20 to 100.
        const auto done = static_cast<std::size_t>(++closure_.applications);
        report(progress_, done, std::max<std::size_t>(done, 100));
    }

    Exchange& exchange_;
    const Hemispheres& hemispheres_;
    const Progress& progress_;
    Closure& closure_;
    std::vector<double> ones_, product_, outflow_, slope_;  // slope: of outflow, by the logarithm of a row's own scale
};

}  // namespace

Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress, double tolerance) {
    Closure closure;
    Closing closing(exchange, hemispheres, progress, closure);
    closing.measure();
    for (int round = 0; round < warm_up_rounds && closure.residual > tolerance; ++round) {
        closing.sinkhorn_round();
        closing.measure();
    }
    for (; closure.rounds < newton_rounds && closure.residual > tolerance; ++closure.rounds) {
        closing.newton_round();
        closing.measure();
    }
    if (closure.residual > tolerance) {
        closing.shrink_rows_above_one();
        closing.measure();
    }
    closure.residual = 0.0;
    for (std::size_t i = 0; i < exchange.size; ++i) {
        const double lacking = 1.0 - closing.row(i), scale = closing.loss_scale(i);
        hemispheres.escape[i] *= scale;
        hemispheres.absorbed[i] *= scale;
        hemispheres.sky[i] *= scale;
        if (lacking > tolerance) {
            hemispheres.absorbed[i] += lacking;
            closure.largest_shortfall = std::max(closure.largest_shortfall, lacking);
            ++closure.short_rows;
        } else {
            closure.residual = std::max(closure.residual, -lacking);
        }
        closure.largest_correction = std::max(closure.largest_correction, std::abs(exchange.scale[i] - 1.0));
    }
    return closure;
}

}  // namespace surflux
