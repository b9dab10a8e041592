#include "surflux/transfer/tilted_light.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace surflux {

namespace {

// The bodies are written once and inlined into one function per instruction set, none of which has FMA: that would
// round otherwise.
#define SURFLUX_KERNEL [[gnu::always_inline]] inline

typedef float Four __attribute__((vector_size(16)));
typedef float Eight __attribute__((vector_size(32)));
typedef double FourDoubles __attribute__((vector_size(32)));
typedef std::int32_t FourInts __attribute__((vector_size(16)));
typedef std::int16_t EightShorts __attribute__((vector_size(16)));
typedef std::int8_t EightBytes __attribute__((vector_size(8)));

static_assert(TransportOperator::tilted_channels == 12 && colors == 4);

constexpr std::size_t ahead_links = 32, ahead_entries = 32;

// Filled with its element k.
#define SURFLUX_SPREAD(of, k) __builtin_shufflevector(of, of, k, k, k, k)

// Sums of eight floats, in two registers or in one. Weights are those of four numbers: of number k, one for each half.
struct Narrow {
    struct Weights {
        Four low, high;
    };
    Four low = {}, high = {};
    template <int k>
    SURFLUX_KERNEL void add(const Weights& weights, const Four& of_both) {
        low += SURFLUX_SPREAD(weights.low, k) * of_both;
        high += SURFLUX_SPREAD(weights.high, k) * of_both;
    }
    SURFLUX_KERNEL void add(float weight, const float* from) {
        Four of[2];
        std::memcpy(of, from, sizeof of);
        low += weight * of[0];
        high += weight * of[1];
    }
    SURFLUX_KERNEL void write(Four& to_low, Four& to_high) const { to_low = low, to_high = high; }
};

struct Wide {
    struct Weights {
        SURFLUX_KERNEL Weights(const Four& low, const Four& high)
            : both(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7)) {}
        Eight both;
    };
    Eight both = {};
    template <int k>
    SURFLUX_KERNEL void add(const Weights& weights, const Four& of_both) {
        both += __builtin_shufflevector(weights.both, weights.both, k, k, k, k, 4 + k, 4 + k, 4 + k, 4 + k) *
                __builtin_shufflevector(of_both, of_both, 0, 1, 2, 3, 0, 1, 2, 3);
    }
    SURFLUX_KERNEL void add(float weight, const float* from) {
        Eight of;
        std::memcpy(&of, from, sizeof of);
        both += weight * of;
    }
    SURFLUX_KERNEL void write(Four& to_low, Four& to_high) const {
        to_low = __builtin_shufflevector(both, both, 0, 1, 2, 3);
        to_high = __builtin_shufflevector(both, both, 4, 5, 6, 7);
    }
};

template <class Sums>
SURFLUX_KERNEL void gather_kernel(const TransportOperator& transport, const float* sent, std::size_t begin,
                                  std::size_t end, float* out) {
    using Link = TransportOperator::Link;
    using Slope = TransportOperator::Slope;
    static_assert(sizeof(Slope) == 2);
    const Link* links = transport.links.data();
    const Slope* slopes = transport.slopes.data();
    const std::size_t count = transport.links.size();
    for (std::size_t k = begin; k < end; ++k) {
        const TransportOperator::Row& row = transport.rows[k];
        Sums value_and_u;
        Four value, u, v = {};
        std::uint32_t l = row.begin;
        for (; l + 4 <= row.end; l += 4) {
            const Link* next = links + std::min(l + ahead_links, count - 4);
            for (int i = 0; i < 4; ++i) __builtin_prefetch(sent + colors * TransportOperator::sender(next[i]));
            // Four links at once: numbers of rays, and slopes, of which u is in the lower half of 32 bits.
            FourInts four;
            std::memcpy(&four, links + l, sizeof four);
            EightBytes bytes;
            std::memcpy(&bytes, slopes + l, sizeof bytes);
            const auto u_and_v = (FourInts) __builtin_convertvector(bytes, EightShorts);
            const Four met = __builtin_convertvector(four & ((1 << TransportOperator::ray_bits) - 1), Four);
            const Four met_u = met * __builtin_convertvector((u_and_v << 16) >> 16, Four);
            const Four met_v = met * __builtin_convertvector(u_and_v >> 16, Four);
            const typename Sums::Weights weights{met, met_u};
#define SURFLUX_ADD(i)                                                                            \
    do {                                                                                          \
        Four from;                                                                                \
        std::memcpy(&from, sent + colors * TransportOperator::sender(links[l + i]), sizeof from); \
        value_and_u.template add<i>(weights, from);                                               \
        v += SURFLUX_SPREAD(met_v, i) * from;                                                     \
    } while (false)
            SURFLUX_ADD(0);
            SURFLUX_ADD(1);
            SURFLUX_ADD(2);
            SURFLUX_ADD(3);
#undef SURFLUX_ADD
        }
        for (; l < row.end; ++l) {
            const float met = TransportOperator::rays_of(links[l]);
            const Four one = {met, met, met, met};
            Four from;
            std::memcpy(&from, sent + colors * TransportOperator::sender(links[l]), sizeof from);
            value_and_u.template add<0>({one, one * static_cast<float>(slopes[l].u)}, from);
            v += one * static_cast<float>(slopes[l].v) * from;
        }
        value_and_u.write(value, u);
        constexpr float of_slope = 1.0f / ShotRows::slope_scale;
        const Frame frame = frame_around(transport.normals[k]);
        float* to = out + k * TransportOperator::tilted_channels;
        for (std::size_t c = 0; c < 3; ++c) {
            const float tilt_u = row.per_ray * (of_slope * u[c] - row.u * value[c]);
            const float tilt_v = row.per_ray * (of_slope * v[c] - row.v * value[c]);
            to[c] = row.per_ray * value[c];
            for (int axis = 0; axis < 3; ++axis)
                to[3 * static_cast<std::size_t>(axis + 1) + c] =
                    tilt_u * static_cast<float>(frame.u[axis]) + tilt_v * static_cast<float>(frame.v[axis]);
        }
    }
}

template <class Sums>
SURFLUX_KERNEL void irradiance_kernel(const SparseRows& at_surfels, const Vec3* normals, const float* coefficients,
                                      std::size_t begin, std::size_t end, Rgb* out) {
    constexpr std::size_t channels = TransportOperator::tilted_channels;
    const SparseRows::Entry* entries = at_surfels.entries.data();
    const std::size_t count = at_surfels.entries.size();
    for (std::size_t i = begin; i < end; ++i) {
        Sums first;
        Four low, middle, high = {};
        for (std::uint32_t k = at_surfels.begin[i]; k < at_surfels.begin[i + 1]; ++k) {
            __builtin_prefetch(coefficients + channels * entries[std::min(k + ahead_entries, count - 1)].column);
            const float* from = coefficients + channels * entries[k].column;
            first.add(entries[k].weight, from);
            Four last;
            std::memcpy(&last, from + 8, sizeof last);
            high += entries[k].weight * last;
        }
        first.write(low, middle);
        const FourDoubles value = __builtin_convertvector(low, FourDoubles),
                          x = __builtin_convertvector(__builtin_shufflevector(low, middle, 3, 4, 5, 5), FourDoubles),
                          y = __builtin_convertvector(__builtin_shufflevector(middle, high, 2, 3, 4, 4), FourDoubles),
                          z = __builtin_convertvector(__builtin_shufflevector(high, high, 1, 2, 3, 3), FourDoubles);
        const Vec3& n = normals[i];
        const FourDoubles all = value + n.x * x + n.y * y + n.z * z;
        const FourDoubles held = all > 0.0 ? all : FourDoubles{};
        out[i] = {held[0], held[1], held[2]};
    }
}

#define SURFLUX_KERNELS(suffix, Sums, attribute)                                                             \
    attribute void gather_##suffix(const TransportOperator& transport, const float* sent, std::size_t begin, \
                                   std::size_t end, float* out) {                                            \
        gather_kernel<Sums>(transport, sent, begin, end, out);                                               \
    }                                                                                                        \
    attribute void irradiance_##suffix(const SparseRows& at_surfels, const Vec3* normals, const float* of,   \
                                       std::size_t begin, std::size_t end, Rgb* out) {                       \
        irradiance_kernel<Sums>(at_surfels, normals, of, begin, end, out);                                   \
    }

SURFLUX_KERNELS(baseline, Narrow, )
#if defined(__x86_64__)
SURFLUX_KERNELS(avx2, Wide, [[gnu::target("avx2")]])
#endif

struct Dispatch {
    decltype(&gather_baseline) gather = gather_baseline;
    decltype(&irradiance_baseline) irradiance = irradiance_baseline;
};

const Dispatch& dispatch() {
    static const Dispatch chosen = [] {
#if defined(__x86_64__)
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx2")) return Dispatch{gather_avx2, irradiance_avx2};
#endif
        return Dispatch{};
    }();
    return chosen;
}

}  // namespace

void gather_tilted_rows(const TransportOperator& transport, const float* sent, std::size_t begin, std::size_t end,
                        float* out) {
    dispatch().gather(transport, sent, begin, end, out);
}

void irradiance_at_rows(const SparseRows& at_surfels, const std::vector<Vec3>& normals, const float* coefficients,
                        std::size_t begin, std::size_t end, Rgb* out) {
    dispatch().irradiance(at_surfels, normals.data(), coefficients, begin, end, out);
}

}  // namespace surflux
