#include "surflux/lights/patch_rays.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/free_directions.h"

namespace surflux {

namespace {

constexpr std::size_t rays_of_ground = 128;
constexpr std::size_t across = 4;  // parts of a patch, each way, by which it is integrated
constexpr double golden_ratio = 0.61803398874989485;

// Van der Corput's sequence, of base 2.
double radical_inverse(std::size_t k) {
    double out = 0.0;
    for (double half = 0.5; k > 0; k /= 2, half *= 0.5) out += k % 2 == 1 ? half : 0.0;
    return out;
}

}  // namespace

PatchRays::PatchRays(const SkyPatches& patches, std::size_t of_patch, std::uint64_t seed) {
    EvenPoints even(2, seed, 0);
    Random random(seed, 1);
    const double turn = random.uniform(), rise = random.uniform();
    std::size_t column = 0;
    for (std::size_t p = 0; p < patches.size(); ++p) {
        Patch patch{patches.solid_angles()[p], patches.directions()[p], {}, 1.0, directions_.size()};
        for (std::size_t r = 0; p == 0 && r < rays_of_ground; ++r) {
            const double* u = even.next();
            directions_.push_back(patches.place_in(p, u[0], u[1]));
        }
        if (p > 0) column = p > 1 && patches.row_of(p) == patches.row_of(p - 1) ? column + 1 : 0;
        for (std::size_t r = 0; p > 0 && r < of_patch; ++r) {
            const auto part = static_cast<double>(r);
            const double u = radical_inverse(patches.row_of(p)) + turn + part / static_cast<double>(of_patch);
            const double v = (static_cast<double>(column) + part) * golden_ratio + rise;
            directions_.push_back(patches.place_in(p, u - std::floor(u), v - std::floor(v)));
        }
        for (std::size_t i = 0; p > 0 && i < across * across; ++i) {
            const auto part = [](std::size_t k) { return (static_cast<double>(k) + 0.5) / across; };
            parts_.push_back(patches.place_in(p, part(i % across), part(i / across)));
            patch.mean += parts_.back() / (across * across);
        }
        double cosine = p == 0 ? 0.0 : 1.0;
        for (const double u : {0.0, 0.5, 1.0})
            for (const double v : {0.0, 1.0})
                if (p > 0) cosine = std::min(cosine, dot(patch.middle, patches.place_in(p, u, v)));
        patch.sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
        patches_.push_back(patch);
    }
}

double PatchRays::unoccluded(std::size_t patch, const Vec3& normal) const {
    const Patch& of = patches_[patch];
    if (patch == 0) return 0.5 * pi * std::max(0.0, 1.0 - normal.z);
    const double facing = dot(normal, of.middle);
    if (facing <= -of.sine) return 0.0;
    if (facing >= of.sine) return of.solid_angle * dot(normal, of.mean);
    double sum = 0.0;  // the plane's own horizon runs through it
    const Vec3* part = parts_.data() + (patch - 1) * across * across;
    for (std::size_t i = 0; i < across * across; ++i) sum += std::max(0.0, dot(normal, part[i]));
    return of.solid_angle * sum / (across * across);
}

void PatchRays::add_row(const Vec3& normal, const std::uint8_t* bits, double* out) const {
    double open = 0.0, arrives = 0.0;  // of the patches that rays went to
    for (std::size_t p = 0; p < patches_.size(); ++p) {
        const double all = unoccluded(p, normal);
        if (all == 0.0) continue;
        const std::size_t last = p + 1 < patches_.size() ? patches_[p + 1].ray : directions_.size();
        double facing = 0.0, free = 0.0;
        for (std::size_t r = patches_[p].ray; r < last; ++r) {
            const double cosine = std::max(0.0, dot(normal, directions_[r]));
            facing += cosine;
            if ((bits[r / 8] >> (7 - r % 8) & 1) != 0) free += cosine;
        }
        if (facing == 0.0) {
            out[p] = -all;
            continue;
        }
        out[p] = all * (free / facing);
        open += all;
        arrives += out[p];
    }
    // Marked by the sign: patches of which so little rises over the plane that none of their rays does. They bring next
    // to nothing, of which the same share arrives as of the others.
    const double share = open > 0.0 ? arrives / open : 0.0;
    for (std::size_t p = 0; p < patches_.size(); ++p)
        if (out[p] < 0.0) out[p] *= -share;
}

std::vector<double> PatchRays::coefficients(const std::vector<Vec3>& normals, const std::uint8_t* bits) const {
    const std::size_t bytes = FreeDirections::row_bytes(directions_.size());
    std::vector<double> out(normals.size() * patches_.size(), 0.0);
    parallel_for(normals.size(), 64,
                 [&](std::size_t i) { add_row(normals[i], bits + i * bytes, out.data() + i * patches_.size()); });
    return out;
}

}  // namespace surflux
