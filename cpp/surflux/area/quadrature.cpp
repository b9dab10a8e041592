#include "surflux/area/quadrature.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>

namespace surflux {

namespace {

// The body is written once, for the compiler to vectorize, and inlined into one function per instruction set.
// It holds no Eigen types: their alignment would differ between the copies.
#define SURFLUX_KERNEL [[gnu::always_inline]] inline

// exp, relative error below 2e-7 for |x| <= 80 and held there beyond: 2^n p(f), n = round(x log2 e), p a polynomial on
// [-1/2, 1/2].
SURFLUX_KERNEL float exp_bounded(float x) {
    const float y = (x < -80.0f ? -80.0f : x > 80.0f ? 80.0f : x) * 1.44269504f;
    const float shifted = y + 12582912.0f;  // 1.5 * 2^23: rounds to an integer in the low bits
    const float f = y - (shifted - 12582912.0f);
    float p = 1.54035304e-4f;
    p = p * f + 1.33335581e-3f;
    p = p * f + 9.61812911e-3f;
    p = p * f + 5.55041087e-2f;
    p = p * f + 2.40226507e-1f;
    p = p * f + 6.93147181e-1f;
    p = p * f + 1.0f;
    std::int32_t bits;
    std::memcpy(&bits, &shifted, 4);
    bits = (bits - 0x4b400000 + 127) << 23;  // minus the bits of 1.5 * 2^23; biased, as the exponent of 2^n
    float scale;
    std::memcpy(&scale, &bits, 4);
    return p * scale;
}

// Natural logarithm for x > 0, absolute error below 1e-6: exponent and mantissa in [sqrt 1/2, sqrt 2), and the series
// of 2 atanh((m - 1) / (m + 1)).
SURFLUX_KERNEL float fast_log(float x) {
    std::int32_t bits;
    std::memcpy(&bits, &x, 4);
    const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // of x / sqrt(1/2), whose bits these are, rounded down
    bits -= exponent * (1 << 23);
    float m;
    std::memcpy(&m, &bits, 4);
    const float r = (m - 1.0f) / (m + 1.0f), r2 = r * r;
    return 0.69314718f * static_cast<float>(exponent) +
           2.0f * r * (1.0f + r2 * (1.0f / 3.0f + r2 * (0.2f + r2 * (1.0f / 7.0f))));
}

// The pixel centres of one row of the grid that lie inside the disk.
struct Row {
    int length;
    float first_s;
};

SURFLUX_KERNEL Row row_of(float t, int resolution) {
    const float step = 2.0f / static_cast<float>(resolution);
    const float half = std::sqrt(1.0f - t * t);
    const int first = static_cast<int>(std::ceil((1.0f - half) / step - 0.5f));
    return {resolution - 2 * first, -1.0f + (static_cast<float>(first) + 0.5f) * step};
}

SURFLUX_KERNEL double sum_of(const float* values, int length) {
    float lanes[16] = {};
    for (int i = 0; i < length; ++i) lanes[i % 16] += values[i];
    double sum = 0.0;
    for (float part : lanes) sum += static_cast<double>(part);
    return sum;
}

SURFLUX_KERNEL double paper_kernel(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    alignas(64) float own[max_resolution], weight[max_resolution], stretched[max_resolution];
    const float step = 2.0f / static_cast<float>(resolution);
    double sum = 0.0;
    for (int row = 0; row < resolution; ++row) {
        const float t = -1.0f + (static_cast<float>(row) + 0.5f) * step;
        const Row inside = row_of(t, resolution);
        const int length = inside.length;
        const float s0 = inside.first_s;
        for (std::size_t k = 0; k < count; ++k) {
            const DiskTerm& d = terms[k];
            const float a = d.c00 + t * (d.c01 + t * d.c02), b = d.c10 + t * d.c11, c = d.c20;
            // Nothing of disk k over this row: the parabola in s stays above 1.
            if (4.0f * c * (a - 1.0f) > b * b) continue;
            for (int i = 0; i < length; ++i) {
                const float s = s0 + static_cast<float>(i) * step;
                const float q = a + s * (b + s * c);
                const float w = q <= 1.0f ? exp_bounded(-kappa * std::sqrt(q < 0.0f ? 0.0f : q)) : 0.0f;
                if (k == 0) {
                    own[i] = weight[i] = w;
                    stretched[i] = w * d.stretch;
                } else {
                    weight[i] += w;
                    stretched[i] += w * d.stretch;
                }
            }
        }
        for (int i = 0; i < length; ++i) own[i] = own[i] / weight[i] * (stretched[i] / weight[i]);
        sum += sum_of(own, length);
    }
    return sum * static_cast<double>(step) * static_cast<double>(step);
}

// Directions times rings that are worked on together: what they need stays in the first-level cache.
constexpr int chunk = 512;

// The weight of sharer j at (x, y, z), over that of the surfel itself, whose square distance is `square`, without its
// taper. `cubed` where kappa is 3, the default: no logarithm then.
template <bool cubed>
SURFLUX_KERNEL float part_of(const Sharer& j, float x, float y, float z, float square, float kappa) {
    const float dx = x - j.x, dy = y - j.y, dz = z - j.z;
    const float q = dx * dx + dy * dy + dz * dz;
    const float taper = 1.0f - q * j.inverse_square_radius;
    const float nearer = square / (q < 1e-9f ? 1e-9f : q);
    const float power = cubed ? nearer * nearer * nearer : exp_bounded(kappa * fast_log(nearer));
    return taper > 0.0f ? power * taper : 0.0f;
}

template <bool cubed>
SURFLUX_KERNEL double curved_kernel(const CurvedSurface& m, const Sharer* sharers, std::size_t count, const float* ends,
                                    float kappa, const PolarGrid& grid, const SharerEnd* sharer_ends,
                                    std::size_t sharer_end_count) {
    alignas(64) float x[chunk], y[chunk], z[chunk], area[chunk], square[chunk], own[chunk], ratio[chunk], part[chunk];
    const float own_z = std::sqrt(1.0f - std::fmin(m.gx * m.gx + m.gy * m.gy, 0.75f));
    const float own_taper = sharers[0].inverse_square_radius;
    const int rings = grid.rings, together = chunk / rings;
    double sum = 0.0;
    for (int first = 0; first < grid.directions; first += together) {
        const int directions = grid.directions - first < together ? grid.directions - first : together;
        const int length = directions * rings;
        for (int d = 0; d < directions; ++d) {
            const float end = ends[first + d], c = end * grid.cosine[static_cast<std::size_t>(first + d)],
                        s = end * grid.sine[static_cast<std::size_t>(first + d)];
            const float* radius = grid.radius.data();
            const float* weight = grid.weight.data();
            for (int k = 0; k < rings; ++k) {
                x[d * rings + k] = c * radius[k];
                y[d * rings + k] = s * radius[k];
                area[d * rings + k] = end * end * weight[k];
            }
        }
        // The surface over each point, the square of the distance from the surfel, and its own taper.
        for (int i = 0; i < length; ++i) {
            const float tx = m.gx + m.kxx * x[i] + m.kxy * y[i], ty = m.gy + m.kxy * x[i] + m.kyy * y[i];
            const float across = tx * tx + ty * ty, nz = std::sqrt(1.0f - (across < 0.75f ? across : 0.75f));
            const float rise = -(x[i] * (m.gx + tx) + y[i] * (m.gy + ty)) / (own_z + nz);
            const float q = x[i] * x[i] + y[i] * y[i] + rise * rise;
            const float taper = 1.0f - q * own_taper;
            z[i] = m.z0 + rise;
            square[i] = q;
            area[i] = taper > 0.0f ? area[i] / nz : 0.0f;
            own[i] = taper > 0.0f ? taper : 1.0f;
            ratio[i] = 0.0f;
        }
        std::size_t e = 0;
        for (std::size_t k = 1; k < count; ++k) {
            const Sharer& j = sharers[k];
            const bool is_ended = e < sharer_end_count && sharer_ends[e].sharer == k;
            for (int i = 0; is_ended && i < length; ++i) part[i] = 1.0f;
            for (; e < sharer_end_count && sharer_ends[e].sharer == k; ++e) {
                const SharerEnd& end = sharer_ends[e];
                for (int i = 0; i < length; ++i)
                    part[i] = end.x * x[i] + end.y * y[i] + end.z * z[i] <= end.limit ? part[i] : 0.0f;
            }
            if (is_ended)
                for (int i = 0; i < length; ++i)
                    ratio[i] += part[i] * part_of<cubed>(j, x[i], y[i], z[i], square[i], kappa);
            else
                for (int i = 0; i < length; ++i) ratio[i] += part_of<cubed>(j, x[i], y[i], z[i], square[i], kappa);
        }
        for (int i = 0; i < length; ++i) area[i] *= own[i] / (own[i] + ratio[i]);
        sum += sum_of(area, length);
    }
    return sum;
}

#define SURFLUX_KERNELS(suffix, attribute)                                                                            \
    attribute double paper_##suffix(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {          \
        return paper_kernel(terms, count, kappa, resolution);                                                         \
    }                                                                                                                 \
    attribute double curved_##suffix(const CurvedSurface& surface, const Sharer* sharers, std::size_t count,          \
                                     const float* ends, float kappa, const PolarGrid& grid,                           \
                                     const SharerEnd* sharer_ends, std::size_t sharer_end_count) {                    \
        return kappa == 3.0f                                                                                          \
                   ? curved_kernel<true>(surface, sharers, count, ends, kappa, grid, sharer_ends, sharer_end_count)   \
                   : curved_kernel<false>(surface, sharers, count, ends, kappa, grid, sharer_ends, sharer_end_count); \
    }

SURFLUX_KERNELS(baseline, )
#if defined(__x86_64__)
SURFLUX_KERNELS(avx2, [[gnu::target("avx2,fma")]])
SURFLUX_KERNELS(avx512, [[gnu::target("avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,prefer-vector-width=512")]])
#endif

struct Dispatch {
    double (*paper)(const DiskTerm*, std::size_t, float, int) = paper_baseline;
    double (*curved)(const CurvedSurface&, const Sharer*, std::size_t, const float*, float, const PolarGrid&,
                     const SharerEnd*, std::size_t) = curved_baseline;
    const char* name = "generic";
};

Dispatch choose() {
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        return {paper_avx512, curved_avx512, "avx512"};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return {paper_avx2, curved_avx2, "avx2"};
    return {paper_baseline, curved_baseline, "x86-64-v2"};
#else
    return {};
#endif
}

const Dispatch& dispatch() {
    static const Dispatch chosen = choose();
    return chosen;
}

}  // namespace

double integrate_paper(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    return dispatch().paper(terms, count, kappa, resolution);
}

double integrate_curved(const CurvedSurface& surface, const Sharer* sharers, std::size_t count, const float* ends,
                        float kappa, const PolarGrid& grid, const SharerEnd* sharer_ends,
                        std::size_t sharer_end_count) {
    return dispatch().curved(surface, sharers, count, ends, kappa, grid, sharer_ends, sharer_end_count);
}

const char* instruction_set() { return dispatch().name; }

}  // namespace surflux
