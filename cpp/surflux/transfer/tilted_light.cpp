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

constexpr std::size_t ahead_entries = 32;

// Filled with its element k.
#define SURFLUX_SPREAD(of, k) __builtin_shufflevector(of, of, k, k, k, k)

SURFLUX_KERNEL Four sent_by(TransportOperator::Link link, const float* sent) {
    Four out;
    std::memcpy(&out, sent + colors * TransportOperator::sender(link), sizeof out);
    return out;
}

// Four links at once: what each met, in numbers of rays.
struct FourLinks {
    SURFLUX_KERNEL explicit FourLinks(const TransportOperator::Link* first) : links(first) {
        FourInts four;
        std::memcpy(&four, links, sizeof four);
        met = __builtin_convertvector(four & ((1 << TransportOperator::ray_bits) - 1), Four);
    }
    template <int k>
    SURFLUX_KERNEL Four from(const float* sent) const {
        return sent_by(links[k], sent);
    }
    const TransportOperator::Link* links;
    Four met;
};

// Sums of twelve floats, in three registers or in two. Weights are those of four numbers: of number k, three,
// one for each four of the floats.
struct Narrow {
    struct Weights {
        Four first, second, third;
    };
    Four first = {}, second = {}, third = {};
    template <int k>
    SURFLUX_KERNEL void add(const Weights& weights, const Four& of_all) {
        first += SURFLUX_SPREAD(weights.first, k) * of_all;
        second += SURFLUX_SPREAD(weights.second, k) * of_all;
        third += SURFLUX_SPREAD(weights.third, k) * of_all;
    }
    SURFLUX_KERNEL void add(float weight, const float* from) {
        Four of[3];
        std::memcpy(of, from, sizeof of);
        first += weight * of[0];
        second += weight * of[1];
        third += weight * of[2];
    }
    SURFLUX_KERNEL void operator+=(const Narrow& other) {
        first += other.first, second += other.second, third += other.third;
    }
    SURFLUX_KERNEL void write(Four (&to)[3]) const { to[0] = first, to[1] = second, to[2] = third; }
};

struct Wide {
    struct Weights {
        SURFLUX_KERNEL Weights(const Four& first, const Four& second, const Four& third)
            : both(__builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7)), last(third) {}
        Eight both;
        Four last;
    };
    Eight both = {};
    Four last = {};
    template <int k>
    SURFLUX_KERNEL void add(const Weights& weights, const Four& of_all) {
        both += __builtin_shufflevector(weights.both, weights.both, k, k, k, k, 4 + k, 4 + k, 4 + k, 4 + k) *
                __builtin_shufflevector(of_all, of_all, 0, 1, 2, 3, 0, 1, 2, 3);
        last += SURFLUX_SPREAD(weights.last, k) * of_all;
    }
    SURFLUX_KERNEL void add(float weight, const float* from) {
        Eight of_both;
        Four of_last;
        std::memcpy(&of_both, from, sizeof of_both);
        std::memcpy(&of_last, from + 8, sizeof of_last);
        both += weight * of_both;
        last += weight * of_last;
    }
    SURFLUX_KERNEL void operator+=(const Wide& other) { both += other.both, last += other.last; }
    SURFLUX_KERNEL void write(Four (&to)[3]) const {
        to[0] = __builtin_shufflevector(both, both, 0, 1, 2, 3);
        to[1] = __builtin_shufflevector(both, both, 4, 5, 6, 7);
        to[2] = last;
    }
};

// Links of a row are added by turns to two sums: each addition would wait for the one before it.
template <class Sums>
SURFLUX_KERNEL void gather_kernel(const TransportOperator& transport, const float* sent, std::size_t begin,
                                  std::size_t end, float* out) {
    using Slope = TransportOperator::Slope;
    static_assert(sizeof(Slope) == 2);
    const Slope* slopes = transport.slopes.data();
    for (std::size_t k = begin; k < end; ++k) {
        const TransportOperator::Row& row = transport.rows[k];
        Sums sums[2];
        std::uint32_t l = row.begin;
        for (; l + 4 <= row.end; l += 4) {
            const FourLinks four(transport.links.data() + l);
            // Slopes of four links, of which u is in the lower half of 32 bits.
            EightBytes bytes;
            std::memcpy(&bytes, slopes + l, sizeof bytes);
            const auto u_and_v = (FourInts) __builtin_convertvector(bytes, EightShorts);
            const Four met_u = four.met * __builtin_convertvector((u_and_v << 16) >> 16, Four);
            const Four met_v = four.met * __builtin_convertvector(u_and_v >> 16, Four);
            const typename Sums::Weights weights{four.met, met_u, met_v};
            sums[0].template add<0>(weights, four.template from<0>(sent));
            sums[1].template add<1>(weights, four.template from<1>(sent));
            sums[0].template add<2>(weights, four.template from<2>(sent));
            sums[1].template add<3>(weights, four.template from<3>(sent));
        }
        for (; l < row.end; ++l) {
            const float met = TransportOperator::rays_of(transport.links[l]);
            const Four one = {met, met, met, met};
            const auto u = static_cast<float>(slopes[l].u), v = static_cast<float>(slopes[l].v);
            sums[0].template add<0>({one, one * u, one * v}, sent_by(transport.links[l], sent));
        }
        sums[0] += sums[1];
        Four found[3];
        sums[0].write(found);
        const Four &value = found[0], &u = found[1], &v = found[2];
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

// The same without gradients.
SURFLUX_KERNEL void colors_kernel(const TransportOperator& transport, const float* sent, std::size_t begin,
                                  std::size_t end, float* out) {
    for (std::size_t k = begin; k < end; ++k) {
        const TransportOperator::Row& row = transport.rows[k];
        Four sums[2] = {};
        std::uint32_t l = row.begin;
        for (; l + 4 <= row.end; l += 4) {
            const FourLinks four(transport.links.data() + l);
            sums[0] += SURFLUX_SPREAD(four.met, 0) * four.from<0>(sent);
            sums[1] += SURFLUX_SPREAD(four.met, 1) * four.from<1>(sent);
            sums[0] += SURFLUX_SPREAD(four.met, 2) * four.from<2>(sent);
            sums[1] += SURFLUX_SPREAD(four.met, 3) * four.from<3>(sent);
        }
        for (; l < row.end; ++l)
            sums[0] += TransportOperator::rays_of(transport.links[l]) * sent_by(transport.links[l], sent);
        const Four all = row.per_ray * (sums[0] + sums[1]);
        std::memcpy(out + k * colors, &all, sizeof all);
    }
}

template <class Sums>
SURFLUX_KERNEL void irradiance_kernel(const SparseRows& at_surfels, const Vec3* normals, const float* coefficients,
                                      std::size_t begin, std::size_t end, Rgb* out) {
    constexpr std::size_t channels = TransportOperator::tilted_channels;
    const SparseRows::Entry* entries = at_surfels.entries.data();
    const std::size_t count = at_surfels.entries.size();
    for (std::size_t i = begin; i < end; ++i) {
        Sums sums;
        for (std::uint32_t k = at_surfels.begin[i]; k < at_surfels.begin[i + 1]; ++k) {
            __builtin_prefetch(coefficients + channels * entries[std::min(k + ahead_entries, count - 1)].column);
            sums.add(entries[k].weight, coefficients + channels * entries[k].column);
        }
        Four found[3];
        sums.write(found);
        const Four &low = found[0], &middle = found[1], &high = found[2];
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
    attribute void colors_##suffix(const TransportOperator& transport, const float* sent, std::size_t begin, \
                                   std::size_t end, float* out) {                                            \
        colors_kernel(transport, sent, begin, end, out);                                                     \
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
    decltype(&colors_baseline) colors = colors_baseline;
    decltype(&irradiance_baseline) irradiance = irradiance_baseline;
};

const Dispatch& dispatch() {
    static const Dispatch chosen = [] {
#if defined(__x86_64__)
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx2")) return Dispatch{gather_avx2, colors_avx2, irradiance_avx2};
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

void gather_color_rows(const TransportOperator& transport, const float* sent, std::size_t begin, std::size_t end,
                       float* out) {
    dispatch().colors(transport, sent, begin, end, out);
}

void irradiance_at_rows(const SparseRows& at_surfels, const std::vector<Vec3>& normals, const float* coefficients,
                        std::size_t begin, std::size_t end, Rgb* out) {
    dispatch().irradiance(at_surfels, normals.data(), coefficients, begin, end, out);
}

}  // namespace surflux
