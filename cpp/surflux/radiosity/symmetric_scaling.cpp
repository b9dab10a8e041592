#include "surflux/radiosity/symmetric_scaling.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

constexpr int warm_up_rounds = 3, newton_rounds = 30, newton_applications = 60;
constexpr double newton_tolerance = 0.1, newton_limit = 1.0;
// Of what is wanted in the end, what a step's system may be off by.
constexpr double newton_margin = 0.01;

// The state of the iteration.
class Iteration {
public:
    Iteration(const ScalingProblem& problem, double largest, const Progress& progress, Scaling& out)
        : problem_(problem),
          largest_(largest),
          progress_(progress),
          out_(out),
          size_(problem.totals.size()),
          work_(size_),
          slope_(size_) {
        out.scale.assign(size_, 1.0);
        out.rows.assign(size_, 0.0);
        out.lost_scale.assign(size_, 1.0);
    }

    void measure() {
        apply(std::vector<double>(size_, 1.0), product_);
        out_.residual = 0.0;
        value_ = 0.0;
        for (std::size_t i = 0; i < size_; ++i) {
            out_.lost_scale[i] = std::pow(out_.scale[i], problem_.yields[i]);
            const double lost = out_.lost_scale[i] * problem_.lost[i];
            out_.rows[i] = (product_[i] + lost) / problem_.totals[i];
            slope_[i] = product_[i] + problem_.yields[i] * lost;
            value_ += 0.5 * product_[i] + lost / problem_.yields[i] - problem_.totals[i] * std::log(out_.scale[i]);
            if (!held(i)) out_.residual = std::max(out_.residual, std::abs(out_.rows[i] - 1.0));
        }
    }

    void sinkhorn_round() {
        for (std::size_t i = 0; i < size_; ++i)
            set_scale(i, out_.rows[i] > 0.0 ? out_.scale[i] / std::sqrt(out_.rows[i]) : largest_);
    }

    // In log scale: (DGD + diag(slope)) step = totals - row sums over the rows that are not held, preconditioned by
    // diag(slope) on both sides (Jacobi). What comes of it is measured.
    //   As precise as the residual is small, which keeps the convergence quadratic (Eisenstat and Walker 1996), and no
    // more than `tolerance` asks for.
    void newton_round(double tolerance) {
        const double precision =
            std::min(newton_tolerance, std::max(out_.residual, newton_margin * tolerance / out_.residual));
        std::vector<double> weight(size_), right(size_), step(size_, 0.0);
        for (std::size_t i = 0; i < size_; ++i) {
            weight[i] = held(i) ? 0.0 : 1.0 / std::sqrt(slope_[i]);
            right[i] = weight[i] * problem_.totals[i] * (1.0 - out_.rows[i]);
        }
        std::vector<double> scaled(size_);
        const LinearOperator hessian = [&](const std::vector<double>& x, std::vector<double>& out) {
            for (std::size_t i = 0; i < size_; ++i) scaled[i] = weight[i] * x[i];
            apply(scaled, out);
            for (std::size_t i = 0; i < size_; ++i) out[i] = x[i] + weight[i] * out[i];
        };
        conjugate_gradients(hessian, right, 1, precision, newton_applications, step);
        // The bound cuts a step short for some rows and not for others: without a line search the projected step may
        // lead uphill, and two rows take turns for ever (Bertsekas 1982).
        const std::vector<double> start = out_.scale, slack = out_.rows;
        const double value = value_;
        double rounding = 0.0;
        for (double total : problem_.totals) rounding += 1e-12 * total;
        for (double part = 1.0;; part *= 0.5) {
            double expected = 0.0;
            for (std::size_t i = 0; i < size_; ++i) {
                if (!(weight[i] > 0.0)) continue;
                out_.scale[i] = start[i];
                set_scale(i, start[i] * std::exp(part * std::clamp(weight[i] * step[i], -newton_limit, newton_limit)));
                expected += problem_.totals[i] * (slack[i] - 1.0) * std::log(out_.scale[i] / start[i]);
            }
            measure();
            if (part < 1e-3 || value_ <= value + 1e-4 * expected + rounding) return;
        }
    }

    // The way out when Newton's method has not converged: symmetric still, and rows at most 1, as yields are.
    void shrink_rows_above_one() {
        for (std::size_t i = 0; i < size_; ++i)
            if (out_.rows[i] > 1.0) out_.scale[i] *= std::pow(out_.rows[i], -1.0 / problem_.yields[i]);
    }

private:
    // At the bound: its row lacks something, but its scale must not grow.
    bool held(std::size_t i) const { return out_.scale[i] >= largest_ && out_.rows[i] < 1.0; }
    void set_scale(std::size_t i, double value) { out_.scale[i] = std::min(value, largest_); }

    // D G D x.
    void apply(const std::vector<double>& x, std::vector<double>& out) {
        for (std::size_t i = 0; i < size_; ++i) work_[i] = out_.scale[i] * x[i];
        problem_.product(work_, out);
        for (std::size_t i = 0; i < size_; ++i) out[i] *= out_.scale[i];
        // How many it takes is not known: most scenes, 20 to 100.
        const auto done = static_cast<std::size_t>(++out_.applications);
        report(progress_, done, std::max<std::size_t>(done, 100));
    }

    const ScalingProblem& problem_;
    double largest_;
    const Progress& progress_;
    Scaling& out_;
    std::size_t size_;
    double value_ = 0.0;                          // of what is minimized
    std::vector<double> work_, product_, slope_;  // slope: of a row's sum, by the logarithm of its own scale
};

}  // namespace

Scaling scale_symmetrically(const ScalingProblem& problem, double largest, double tolerance, const Progress& progress) {
    Scaling out;
    Iteration iteration(problem, largest, progress, out);
    iteration.measure();
    for (int round = 0; round < warm_up_rounds && out.residual > tolerance; ++round) {
        iteration.sinkhorn_round();
        iteration.measure();
    }
    for (; out.rounds < newton_rounds && out.residual > tolerance; ++out.rounds) iteration.newton_round(tolerance);
    if (out.residual > tolerance) {
        iteration.shrink_rows_above_one();
        iteration.measure();
    }
    return out;
}

}  // namespace surflux
