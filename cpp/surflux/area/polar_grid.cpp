#include "surflux/area/polar_grid.h"

#include <cmath>
#include <cstddef>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"

namespace surflux {

PolarGrid::PolarGrid(int resolution) : directions(resolution), rings((resolution + 1) / 2) {
    const double step = 2.0 * pi / directions;
    for (int d = 0; d < directions; ++d) {
        cosine.push_back(static_cast<float>(std::cos((d + 0.5) * step)));
        sine.push_back(static_cast<float>(std::sin((d + 0.5) * step)));
    }
    std::vector<double> nodes, weights;
    gauss_legendre(rings, nodes, weights);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        radius.push_back(static_cast<float>(nodes[k]));
        weight.push_back(static_cast<float>(weights[k] * nodes[k] * step));
    }
}

}  // namespace surflux
