#include "surflux/solution/gmres.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

namespace {

constexpr std::size_t restart_after = 30;
constexpr const char* out_of_range =
    "scene: its light is too strong to compute with: the linear system left the range of float64";
constexpr double rounding = 1e-14;  // what is left of a vector of length 1 where nothing should be

// Summed in order, so that the result is the same for any number of threads.
double inner(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
}

}  // namespace

LinearReport gmres(const LinearOperator& apply, const std::vector<double>& b, std::size_t channels, double tolerance,
                   int max_applications, std::vector<double>& x, const Progress& progress) {
    LinearReport report;
    x.resize(b.size(), 0.0);
    // Channels in units of their right-hand sides, so that none is lost beside a brighter one.
    std::vector<double> unit(channels, 0.0);
    for (std::size_t k = 0; k < b.size(); ++k) unit[k % channels] += b[k] * b[k];
    for (double& size : unit) {
        require(std::isfinite(size), out_of_range);
        size = size > 0.0 ? std::sqrt(size) : 1.0;
    }
    std::vector<double> scaled(b.size()), product, residual(b.size());
    const auto apply_scaled = [&](const std::vector<double>& y, std::vector<double>& out) {
        for (std::size_t k = 0; k < y.size(); ++k) scaled[k] = y[k] * unit[k % channels];
        apply(scaled, out);
        for (std::size_t k = 0; k < out.size(); ++k) out[k] /= unit[k % channels];
        ++report.applications;
    };
    const auto true_residual = [&] {
        apply(x, product);
        ++report.applications;
        std::vector<double> squared(channels, 0.0);
        for (std::size_t k = 0; k < b.size(); ++k) {
            residual[k] = (b[k] - product[k]) / unit[k % channels];
            squared[k % channels] += residual[k] * residual[k];
        }
        report.residual = 0.0;
        for (double sum : squared) {
            require(std::isfinite(sum), out_of_range);  // std::max takes no notice of a NaN
            report.residual = std::max(report.residual, std::sqrt(sum));
        }
    };

    for (true_residual(); report.residual > tolerance && report.applications < max_applications; true_residual()) {
        const double beta = std::sqrt(inner(residual, residual));
        std::vector<std::vector<double>> basis{residual};
        for (double& value : basis[0]) value /= beta;
        // Columns of the Hessenberg matrix, turned into a triangle by Givens rotations as they come.
        std::vector<std::vector<double>> columns;
        std::vector<double> cosines, sines, right{beta};
        while (columns.size() < restart_after && report.applications + 1 < max_applications) {
            surflux::report(progress, percent_done(std::abs(right.back()), tolerance), 100);
            apply_scaled(basis.back(), product);
            const double size = std::sqrt(inner(product, product));
            require(std::isfinite(size), out_of_range);
            std::vector<double> column;
            for (const std::vector<double>& direction : basis) {
                column.push_back(inner(direction, product));
                for (std::size_t k = 0; k < product.size(); ++k) product[k] -= column.back() * direction[k];
            }
            const double rest = std::sqrt(inner(product, product));
            for (std::size_t r = 0; r < cosines.size(); ++r) {
                const double above = column[r];
                column[r] = cosines[r] * above + sines[r] * column[r + 1];
                column[r + 1] = cosines[r] * column[r + 1] - sines[r] * above;
            }
            const double hypotenuse = std::hypot(column.back(), rest);
            if (!(hypotenuse > rounding * size))
                break;  // the operator is singular here: what there is is all there can be
            cosines.push_back(column.back() / hypotenuse);
            sines.push_back(rest / hypotenuse);
            column.back() = hypotenuse;
            right.push_back(-sines.back() * right.back());
            right[right.size() - 2] *= cosines.back();
            columns.push_back(std::move(column));
            if (std::abs(right.back()) <= 0.5 * tolerance || !(rest > 0.0)) break;
            basis.push_back(product);
            for (double& value : basis.back()) value /= rest;
        }
        if (columns.empty()) break;
        std::vector<double> weight(columns.size());
        for (std::size_t r = columns.size(); r-- > 0;) {
            weight[r] = right[r];
            for (std::size_t c = r + 1; c < columns.size(); ++c) weight[r] -= columns[c][r] * weight[c];
            weight[r] /= columns[r][r];
        }
        for (std::size_t c = 0; c < weight.size(); ++c)
            for (std::size_t k = 0; k < x.size(); ++k) x[k] += weight[c] * basis[c][k] * unit[k % channels];
    }
    return report;
}

}  // namespace surflux
