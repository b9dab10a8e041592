#include "surflux/radiosity/closure.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "surflux/solution/conjugate_gradients.h"

namespace surflux {

namespace {

constexpr int warm_up_rounds = 3, newton_applications = 60;
constexpr double newton_tolerance = 0.1, newton_limit = 1.0;

}  // namespace

Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress, double tolerance,
              int max_rounds) {
    const std::size_t n = exchange.size;
    const std::vector<double>& area = exchange.areas;
    std::vector<double>& scale = exchange.scale;
    Closure closure;
    const std::vector<double> ones(n, 1.0);
    std::vector<double> product, weighted(n), outflow(n), row(n), step;
    scale.assign(n, 1.0);
    const auto apply_exchange = [&](const std::vector<double>& x, std::vector<double>& out) {
        exchange.apply(x, out, 1);
        ++closure.applications;
        // How many it takes is not known: most scenes, 20 to 100.
        const auto done = static_cast<std::size_t>(closure.applications);
        report(progress, done, std::max<std::size_t>(done, 100));
    };
    const auto measure = [&] {
        apply_exchange(ones, product);
        closure.residual = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            outflow[i] = product[i] + scale[i] * area[i] * (hemispheres.escape[i] + hemispheres.absorbed[i]);
            row[i] = outflow[i] / area[i];
            // A surfel that neither sees anything nor loses anything (its rays all end on a face that no exchange
            // reaches) has nothing to scale.
            if (row[i] > 0.0) closure.residual = std::max(closure.residual, std::abs(row[i] - 1.0));
        }
    };
    for (int round = 0; round < warm_up_rounds; ++round) {
        measure();
        if (closure.residual <= tolerance) break;
        for (std::size_t i = 0; i < n; ++i)
            if (row[i] > 0.0) scale[i] /= std::sqrt(row[i]);
    }
    for (measure(); closure.residual > tolerance && closure.rounds < max_rounds; ++closure.rounds) {
        // Newton in log scale: (DGD + diag(outflow)) step = A - outflow, made symmetric with unit diagonal.
        std::vector<double> right(n);
        for (std::size_t i = 0; i < n; ++i) {
            weighted[i] = row[i] > 0.0 ? 1.0 / std::sqrt(outflow[i]) : 0.0;
            right[i] = weighted[i] * (area[i] - outflow[i]);
        }
        std::vector<double> scaled(n);
        const LinearOperator apply = [&](const std::vector<double>& x, std::vector<double>& out) {
            for (std::size_t i = 0; i < n; ++i) scaled[i] = weighted[i] * x[i];
            apply_exchange(scaled, out);
            for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + weighted[i] * out[i];
        };
        step.assign(n, 0.0);
        conjugate_gradients(apply, right, 1, newton_tolerance, newton_applications, step);
        for (std::size_t i = 0; i < n; ++i)
            scale[i] *= std::exp(std::clamp(weighted[i] * step[i], -newton_limit, newton_limit));
        measure();
    }
    for (std::size_t i = 0; i < n; ++i) {
        closure.largest_correction = std::max(closure.largest_correction, std::abs(scale[i] - 1.0));
        hemispheres.escape[i] *= scale[i];
        hemispheres.absorbed[i] *= scale[i];
        hemispheres.sky[i] *= scale[i];
    }
    return closure;
}

}  // namespace surflux
