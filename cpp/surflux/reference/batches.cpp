#include "surflux/reference/batches.h"

#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

Batches::Batches(std::size_t samples) {
    require(samples >= least, "samples: wanted at least ", least, ", got ", samples);
    while (4 * per_batch * per_batch <= samples && 2 * per_batch * least <= samples) per_batch *= 2;
    count = std::max(least, (samples + per_batch - 1) / per_batch);
    per_chunk = std::max<std::size_t>(1, paths_at_once / per_batch);
    chunks = (count + per_chunk - 1) / per_chunk;
}

void Moments::add(const Moments& other) {
    if (other.count == 0.0) return;
    const double total = count + other.count;
    const Rgb off = other.mean - mean;
    mean += (other.count / total) * off;
    spread += other.spread + (count * other.count / total) * (off * off);
    count = total;
}

Rgb Moments::error() const {
    const Rgb variance = spread / (count * (count - 1.0));
    return {std::sqrt(variance.x), std::sqrt(variance.y), std::sqrt(variance.z)};
}

}  // namespace surflux
