#include "surflux/solution/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

namespace {

// Per channel; summed in order, so that the result is the same for any number of threads.
std::vector<double> inner(const std::vector<double>& a, const std::vector<double>& b, std::size_t channels) {
    std::vector<double> sum(channels, 0.0);
    for (std::size_t k = 0; k < a.size(); ++k) sum[k % channels] += a[k] * b[k];
    return sum;
}

}  // namespace

std::size_t percent_done(double residual, double tolerance) {
    if (residual >= 1.0) return 0;
    return static_cast<std::size_t>(std::clamp(100.0 * std::log(residual) / std::log(tolerance), 0.0, 99.0));
}

LinearReport conjugate_gradients(const LinearOperator& apply, const std::vector<double>& b, std::size_t channels,
                                 double tolerance, int max_applications, std::vector<double>& x,
                                 const Progress& progress) {
    LinearReport report;
    std::vector<double> product, r(b.size()), p;
    const std::vector<double> scale = inner(b, b, channels);
    x.resize(b.size(), 0.0);

    const auto true_residual = [&] {
        apply(x, product);
        ++report.applications;
        for (std::size_t k = 0; k < b.size(); ++k) r[k] = b[k] - product[k];
    };
    const auto worst = [&](const std::vector<double>& squared) {
        double largest = 0.0;
        for (std::size_t c = 0; c < channels; ++c)
            if (scale[c] > 0.0) largest = std::max(largest, std::sqrt(squared[c] / scale[c]));
        for (std::size_t c = 0; c < channels; ++c)
            require(std::isfinite(squared[c]) && std::isfinite(scale[c]),
                    "scene: its light is too strong, or too weak, to compute with: the linear system left the range of "
                    "float64");
        return largest;
    };

    // The recurrence for r drifts from b - A x; a restart from the true residual mends that.
    for (int restart = 0; restart < 4; ++restart) {
        true_residual();
        std::vector<double> rr = inner(r, r, channels);
        report.residual = worst(rr);
        if (report.residual <= tolerance || report.applications >= max_applications) break;
        p = r;
        while (worst(rr) > 0.9 * tolerance && report.applications < max_applications) {
            surflux::report(progress, percent_done(worst(rr), tolerance), 100);
            apply(p, product);
            ++report.applications;
            const std::vector<double> curvature = inner(p, product, channels);
            for (std::size_t k = 0; k < b.size(); ++k) {
                const std::size_t c = k % channels;
                if (curvature[c] <= 0.0) continue;
                const double step = rr[c] / curvature[c];
                x[k] += step * p[k];
                r[k] -= step * product[k];
            }
            const std::vector<double> next = inner(r, r, channels);
            for (std::size_t k = 0; k < b.size(); ++k) {
                const std::size_t c = k % channels;
                p[k] = r[k] + (rr[c] > 0.0 ? next[c] / rr[c] : 0.0) * p[k];
            }
            rr = next;
        }
    }
    return report;
}

}  // namespace surflux
