#include "surflux/solution/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

LinearReport conjugate_gradients(const LinearOperator& apply, const std::vector<double>& b,
                                 const LinearSystems& systems, double tolerance, int max_applications,
                                 std::vector<double>& x, const Progress& progress) {
    LinearReport report;
    std::vector<double> product, r(b.size()), p;
    const std::size_t count = systems.count();
    const std::vector<std::uint32_t> system = systems.of(b.size());
    const auto inner = [&](const std::vector<double>& u, const std::vector<double>& v) {
        std::vector<double> sums(count);
        inner_products(u, v, system, sums);
        return sums;
    };
    const std::vector<double> scale = inner(b, b);
    x.resize(b.size(), 0.0);

    const auto true_residual = [&] {
        apply(x, product);
        ++report.applications;
        for (std::size_t k = 0; k < b.size(); ++k) r[k] = b[k] - product[k];
    };
    const auto worst = [&](const std::vector<double>& squared) {
        double largest = 0.0;
        for (std::size_t c = 0; c < count; ++c)
            if (scale[c] > 0.0) largest = std::max(largest, std::sqrt(squared[c] / scale[c]));
        for (std::size_t c = 0; c < count; ++c)
            require(std::isfinite(squared[c]) && std::isfinite(scale[c]),
                    "scene: its light is too strong, or too weak, to compute with: the linear system left the range of "
                    "float64");
        return largest;
    };

    // The recurrence for r drifts from b - A x; a restart from the true residual mends that.
    for (int restart = 0; restart < 4; ++restart) {
        true_residual();
        std::vector<double> rr = inner(r, r);
        report.residual = worst(rr);
        if (report.residual <= tolerance || report.applications >= max_applications) break;
        p = r;
        while (worst(rr) > 0.9 * tolerance && report.applications < max_applications) {
            surflux::report(progress, percent_done(worst(rr), tolerance), 100);
            apply(p, product);
            ++report.applications;
            const std::vector<double> curvature = inner(p, product);
            for (std::size_t k = 0; k < b.size(); ++k) {
                const std::size_t c = system[k];
                if (curvature[c] <= 0.0) continue;
                const double step = rr[c] / curvature[c];
                x[k] += step * p[k];
                r[k] -= step * product[k];
            }
            const std::vector<double> next = inner(r, r);
            for (std::size_t k = 0; k < b.size(); ++k) {
                const std::size_t c = system[k];
                p[k] = r[k] + (rr[c] > 0.0 ? next[c] / rr[c] : 0.0) * p[k];
            }
            rr = next;
        }
    }
    return report;
}

}  // namespace surflux
