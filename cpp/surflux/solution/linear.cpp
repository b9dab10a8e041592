#include "surflux/solution/linear.h"

#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

void inner_products(const std::vector<double>& a, const std::vector<double>& b,
                    const std::vector<std::uint32_t>& system, std::vector<double>& out) {
    // A block has sums of its own, which many systems would make longer than itself.
    constexpr std::size_t grain = 1 << 14, most_systems = 64;
    const std::size_t count = out.size();
    std::fill(out.begin(), out.end(), 0.0);
    if (a.size() <= grain || count > most_systems) {
        for (std::size_t k = 0; k < a.size(); ++k) out[system[k]] += a[k] * b[k];
        return;
    }
    std::vector<double> parts((a.size() + grain - 1) / grain * count, 0.0);
    parallel_blocks(a.size(), grain, [&](std::size_t begin, std::size_t end) {
        double* sums = parts.data() + begin / grain * count;
        for (std::size_t k = begin; k < end; ++k) sums[system[k]] += a[k] * b[k];
    });
    for (std::size_t k = 0; k < parts.size(); ++k) out[k % count] += parts[k];
}

std::size_t percent_done(double residual, double tolerance) {
    if (residual >= 1.0) return 0;
    return static_cast<std::size_t>(std::clamp(100.0 * std::log(residual) / std::log(tolerance), 0.0, 99.0));
}

}  // namespace surflux
