#include "surflux/core/gauss_legendre.h"

#include <cmath>
#include <cstddef>

#include "surflux/core/sampling.h"

namespace surflux {

void gauss_legendre(int count, std::vector<double>& nodes, std::vector<double>& weights) {
    nodes.resize(static_cast<std::size_t>(count));
    weights.resize(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
        // Newton's method on the Legendre polynomial P_count, from Tricomi's guess, ascending in x.
        double x = -std::cos(pi * (k + 0.75) / (count + 0.5)), slope = 1.0;
        for (int step = 0; step < 100; ++step) {
            double before = 1.0, value = x;
            for (int degree = 2; degree <= count; ++degree) {
                const double next = ((2 * degree - 1) * x * value - (degree - 1) * before) / degree;
                before = value;
                value = next;
            }
            slope = count * (x * value - before) / (x * x - 1.0);
            const double change = value / slope;
            x -= change;
            if (std::abs(change) < 1e-15) break;
        }
        nodes[static_cast<std::size_t>(k)] = 0.5 * (1.0 + x);
        weights[static_cast<std::size_t>(k)] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

}  // namespace surflux
