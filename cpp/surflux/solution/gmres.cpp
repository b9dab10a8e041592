#include "surflux/solution/gmres.h"

#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t restart_after = 30;
constexpr const char* out_of_range =
    "scene: its light is too strong to compute with: the linear system left the range of float64";
constexpr double rounding = 1e-14;  // relative pivot below which the projected system counts as singular

// Least squares on one system's Hessenberg matrix, turned into a triangle by Givens rotations as its columns come.
class LeastSquares {
public:
    LeastSquares() = default;
    explicit LeastSquares(double beta) : active_(beta > 0.0), right_{beta} {}

    // Has it another direction to look in?
    bool is_active() const { return active_; }
    double residual() const { return std::abs(right_.back()); }
    std::size_t columns() const { return cosines_.size(); }
    void stop() { active_ = false; }

    // `column`: of the last direction's product, its share of each direction so far and what is left of it, `rest`;
    // its length is `size`. False where the operator is singular: what there is, is all there can be.
    bool add(std::vector<double> column, double rest, double size) {
        for (std::size_t r = 0; r < cosines_.size(); ++r) {
            const double above = column[r];
            column[r] = cosines_[r] * above + sines_[r] * column[r + 1];
            column[r + 1] = cosines_[r] * column[r + 1] - sines_[r] * above;
        }
        const double hypotenuse = std::hypot(column.back(), rest);
        if (!(hypotenuse > rounding * size)) return false;
        cosines_.push_back(column.back() / hypotenuse);
        sines_.push_back(rest / hypotenuse);
        column.back() = hypotenuse;
        right_.push_back(-sines_.back() * right_.back());
        right_[right_.size() - 2] *= cosines_.back();
        triangle_.insert(triangle_.end(), column.begin(), column.end());
        return true;
    }

    // What of each direction to take.
    std::vector<double> weights() const {
        const std::size_t n = columns();
        const auto at = [this](std::size_t r, std::size_t c) { return triangle_[c * (c + 1) / 2 + r]; };
        std::vector<double> out(n);
        for (std::size_t r = n; r-- > 0;) {
            out[r] = right_[r];
            for (std::size_t c = r + 1; c < n; ++c) out[r] -= at(r, c) * out[c];
            out[r] /= at(r, r);
        }
        return out;
    }

private:
    bool active_ = false;
    std::vector<double> triangle_, cosines_, sines_, right_;
};

}  // namespace

LinearReport gmres(const LinearOperator& apply, const std::vector<double>& b, const LinearSystems& systems,
                   double tolerance, int max_applications, std::vector<double>& x, const Progress& progress) {
    LinearReport report;
    x.resize(b.size(), 0.0);
    const std::size_t count = systems.count();
    const std::vector<std::uint32_t> system = systems.of(b.size());
    // Systems in units of their right-hand sides, so that none is lost beside a brighter one.
    std::vector<double> unit(count), sums(count);
    inner_products(b, b, system, unit);
    // Where nothing comes in there is nothing, whatever there was at the start.
    for (std::size_t k = 0; k < x.size(); ++k)
        if (unit[system[k]] == 0.0) x[k] = 0.0;
    for (double& size : unit) {
        require(std::isfinite(size), out_of_range);
        size = size > 0.0 ? std::sqrt(size) : 1.0;
    }
    std::vector<double> scaled(b.size()), product, residual(b.size());
    const auto for_unknowns = [&](const auto& body) { parallel_for(b.size(), 1 << 14, body); };
    const auto apply_scaled = [&](const std::vector<double>& y, std::vector<double>& out) {
        for_unknowns([&](std::size_t k) { scaled[k] = y[k] * unit[system[k]]; });
        apply(scaled, out);
        for_unknowns([&](std::size_t k) { out[k] /= unit[system[k]]; });
        ++report.applications;
    };
    std::vector<double> beta(count);  // residual of each
    const auto true_residual = [&] {
        apply(x, product);
        ++report.applications;
        for_unknowns([&](std::size_t k) { residual[k] = (b[k] - product[k]) / unit[system[k]]; });
        inner_products(residual, residual, system, beta);
        report.residual = 0.0;
        for (double& size : beta) {
            size = std::sqrt(size);
            require(std::isfinite(size), out_of_range);  // std::max takes no notice of a NaN
            report.residual = std::max(report.residual, size);
        }
    };

    for (true_residual(); report.residual > tolerance && report.applications < max_applications; true_residual()) {
        std::vector<LeastSquares> small(count);
        for (std::size_t s = 0; s < count; ++s)
            if (beta[s] > tolerance) small[s] = LeastSquares(beta[s]);
        std::vector<std::vector<double>> basis{residual};
        for_unknowns(
            [&](std::size_t k) { basis[0][k] = small[system[k]].is_active() ? residual[k] / beta[system[k]] : 0.0; });
        std::vector<double> size(count), rest(count);
        bool any = true;
        while (any && basis.size() <= restart_after && report.applications + 1 < max_applications) {
            double worst = 0.0;
            for (const LeastSquares& s : small)
                if (s.is_active()) worst = std::max(worst, s.residual());
            surflux::report(progress, percent_done(worst, tolerance), 100);
            apply_scaled(basis.back(), product);
            inner_products(product, product, system, size);
            for (const double squared : size) require(std::isfinite(squared), out_of_range);
            std::vector<std::vector<double>> shares;  // of each direction, by system
            for (const std::vector<double>& direction : basis) {
                inner_products(direction, product, system, sums);
                for_unknowns([&](std::size_t k) { product[k] -= sums[system[k]] * direction[k]; });
                shares.push_back(sums);
            }
            inner_products(product, product, system, rest);
            any = false;
            for (std::size_t s = 0; s < count; ++s) {
                rest[s] = std::sqrt(rest[s]);
                if (!small[s].is_active()) continue;
                std::vector<double> column;
                for (const std::vector<double>& share : shares) column.push_back(share[s]);
                if (!small[s].add(std::move(column), rest[s], std::sqrt(size[s])) ||
                    small[s].residual() <= 0.5 * tolerance || !(rest[s] > 0.0))
                    small[s].stop();
                any = any || small[s].is_active();
            }
            if (!any) break;
            basis.push_back(product);
            for_unknowns([&](std::size_t k) {
                basis.back()[k] = small[system[k]].is_active() ? product[k] / rest[system[k]] : 0.0;
            });
        }
        bool better = false;
        std::vector<std::vector<double>> weights(count);
        for (std::size_t s = 0; s < count; ++s) {
            weights[s] = small[s].weights();
            better = better || !weights[s].empty();
        }
        if (!better) break;
        for_unknowns([&](std::size_t k) {
            const std::vector<double>& of = weights[system[k]];
            for (std::size_t c = 0; c < of.size(); ++c) x[k] += of[c] * basis[c][k] * unit[system[k]];
        });
    }
    return report;
}

}  // namespace surflux
