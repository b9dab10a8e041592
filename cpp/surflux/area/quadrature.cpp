#include "surflux/area/quadrature.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace surflux {

namespace {

// The body is written once, for the compiler to vectorize, and inlined into one function per instruction set.
// It holds no Eigen types: their alignment would differ between the copies.
#define SURFLUX_KERNEL [[gnu::always_inline]] inline

// exp for x <= 0, relative error below 2e-7: 2^n p(f), n = round(x log2 e), p a polynomial on [-1/2, 1/2].
SURFLUX_KERNEL float exp_negative(float x) {
    const float y = x < -87.0f ? -125.5f : x * 1.44269504f;
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
    bits = (bits - 0x4b400000 + 127) << 23;
    float scale;
    std::memcpy(&scale, &bits, 4);
    return p * scale;
}

SURFLUX_KERNEL double integrate(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    alignas(64) float own[max_resolution], weight[max_resolution], stretched[max_resolution];
    const float step = 2.0f / static_cast<float>(resolution);
    double sum = 0.0;
    for (int row = 0; row < resolution; ++row) {
        const float t = -1.0f + (static_cast<float>(row) + 0.5f) * step;
        // Pixel centres of this row inside the disk.
        const float half = std::sqrt(1.0f - t * t);
        const int first = static_cast<int>(std::ceil((1.0f - half) / step - 0.5f));
        const int length = resolution - 2 * first;
        if (length <= 0) continue;
        const float s0 = -1.0f + (static_cast<float>(first) + 0.5f) * step;
        for (std::size_t k = 0; k < count; ++k) {
            const DiskTerm& d = terms[k];
            const float a = d.c00 + t * (d.c01 + t * d.c02), b = d.c10 + t * d.c11, c = d.c20;
            // Nothing of disk k over this row: the parabola in s stays above 1.
            if (4.0f * c * (a - 1.0f) > b * b) continue;
            for (int i = 0; i < length; ++i) {
                const float s = s0 + static_cast<float>(i) * step;
                const float q = a + s * (b + s * c);
                const float w = q <= 1.0f ? exp_negative(-kappa * std::sqrt(q < 0.0f ? 0.0f : q)) : 0.0f;
                if (k == 0) {
                    own[i] = weight[i] = w;
                    stretched[i] = w * d.stretch;
                } else {
                    weight[i] += w;
                    stretched[i] += w * d.stretch;
                }
            }
        }
        float row_sum[16] = {};
        for (int i = 0; i < length; ++i) row_sum[i % 16] += own[i] * stretched[i] / (weight[i] * weight[i]);
        for (float part : row_sum) sum += static_cast<double>(part);
    }
    return sum * static_cast<double>(step) * static_cast<double>(step);
}

using Kernel = double (*)(const DiskTerm*, std::size_t, float, int);

double integrate_baseline(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    return integrate(terms, count, kappa, resolution);
}

#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] double integrate_avx2(const DiskTerm* terms, std::size_t count, float kappa,
                                                  int resolution) {
    return integrate(terms, count, kappa, resolution);
}

[[gnu::target("avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,prefer-vector-width=512")]] double integrate_avx512(
    const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    return integrate(terms, count, kappa, resolution);
}
#endif

struct Dispatch {
    Kernel kernel = integrate_baseline;
    const char* name = "x86-64-v2";
};

Dispatch choose() {
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        return {integrate_avx512, "avx512"};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return {integrate_avx2, "avx2"};
    return {};
#else
    return {integrate_baseline, "generic"};
#endif
}

const Dispatch& dispatch() {
    static const Dispatch chosen = choose();
    return chosen;
}

}  // namespace

double integrate_paper(const DiskTerm* terms, std::size_t count, float kappa, int resolution) {
    return dispatch().kernel(terms, count, kappa, resolution);
}

const char* instruction_set() { return dispatch().name; }

}  // namespace surflux
