#include "surflux/radiosity/exchange.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/radiosity/all_pairs.h"
#include "surflux/radiosity/pair_exchange.h"

namespace surflux {

namespace {

constexpr int most_draws = 64;  // of points, for one in front of the other surfel

// A tuned number of rays.
int whole(double rays) { return std::max(1, static_cast<int>(std::lround(rays))); }

}  // namespace

void require_memory_for_pairs(std::size_t n, double limit) {
    if (limit <= 0.0) limit = 0.75 * available_memory();
    const double wanted = 4.0 * static_cast<double>(n) * static_cast<double>(n);
    require(wanted <= limit, "scene: the exchange of all pairs of ", n, " surfels needs ", wanted / 1e9,
            " GB and there are ", limit / 1e9, " GB for it; at most ", static_cast<std::size_t>(std::sqrt(limit / 4.0)),
            " surfels fit (Surfels.thinned gives fewer)");
}

namespace {

// Share of the exchange that is free to pass between i and a surfel j that fills much of its sky: in contact almost all
// of it passes where the two are closest, which points spread over both would miss. Rays leave i as its light does.
double visible_share_of_hemisphere(const Tracer& tracer, const PairExchange& pairs, std::uint32_t i, std::uint32_t j,
                                   int hemisphere_rays, std::uint64_t seed, std::size_t& rays) {
    const Frame frame = frame_around(pairs.normal(i));
    EvenPoints even(4, seed, (static_cast<std::uint64_t>(i) << 32) | j);
    int all = 0, free = 0;
    for (int k = 0; k < hemisphere_rays; ++k) {
        const double* u = even.next();
        const Vec3 from = pairs.ray_point(i, PairExchange::Range::near, u[0], u[1]);
        Vec3 to;
        if (!pairs.meets(j, from, frame.to_world(square_to_cosine_hemisphere(u[2], u[3])), to)) continue;
        ++all;
        free += tracer.free(segment(tracer.on(i, from), to, j));
    }
    rays += static_cast<std::size_t>(all);
    return all > 0 ? static_cast<double>(free) / all : 0.0;
}

// The same for any pair. Rays are spread over both surfels as far as they are patches, or near, between points that lie
// in front of each other; each counts as much as passes along it.
double visible_share(const Tracer& tracer, const PairExchange& pairs, std::uint32_t i, std::uint32_t j,
                     PairExchange::Range range, double factor, bool extended, const PairsTuning& tuning,
                     std::uint64_t seed, std::size_t& rays) {
    using Range = PairExchange::Range;
    if (range == Range::same_surface) return 1.0;
    if (range == Range::near && pairs.extent(j) < pairs.extent(i)) std::swap(i, j);
    if (range == Range::near && factor > tuning.large_factor)
        return visible_share_of_hemisphere(tracer, pairs, i, j, whole(tuning.hemisphere_rays), seed, rays);
    int count = whole(range == Range::near              ? tuning.near_rays
                      : range == Range::mid && extended ? tuning.mid_rays
                                                        : tuning.far_rays);
    // A pair that matters more than others is looked at more closely: a large one, or one that carries a lamp's light.
    count = std::max(count, static_cast<int>(std::min(tuning.most_rays, tuning.rays_per_factor * factor)));
    if (pairs.is_lamp(i) || pairs.is_lamp(j)) count = std::max(count, whole(tuning.lamp_rays));
    const int most = whole(tuning.more_rays * count);
    EvenPoints even(4, seed, (static_cast<std::uint64_t>(i) << 32) | j);
    const bool patches = pairs.is_patch(i) && pairs.is_patch(j);
    double all = 0.0, free = 0.0;
    int cast = 0;
    for (int k = 0; k < most || (cast == 0 && k < most_draws); ++k) {
        if (cast == count && (!patches || free <= 0.0 || free >= all)) break;
        const double* u = even.next();
        const Vec3 from = pairs.ray_point(i, range, u[0], u[1]), to = pairs.ray_point(j, range, u[2], u[3]);
        const double weight = pairs.kernel(i, from, j, to);
        if (weight <= 0.0) {
            range = Range::near;  // of disks whose centres do not face each other other points may
            continue;
        }
        all += weight;
        if (tracer.free(segment(tracer.on(i, from), to, j))) free += weight;
        ++cast;
    }
    rays += static_cast<std::size_t>(cast);
    return all > 0.0 ? free / all : 0.0;
}

}  // namespace

std::vector<double> self_exchanges(const Scene& scene, const PairExchange& pairs) {
    const Surfels& s = scene.surfels;
    const DiskIndex disks(s.positions, s.radii);
    std::vector<double> out(s.size(), 0.0);
    parallel_blocks(s.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        std::vector<std::uint32_t> overlapping;
        for (std::size_t k = begin; k < end; ++k) {
            const auto i = static_cast<std::uint32_t>(k);
            if (pairs.is_patch(i)) continue;  // flat
            near.clear();
            overlapping.clear();
            disks.reaching(s.positions[i], s.radii[i], near);
            for (const Neighbor& found : near) overlapping.push_back(found.index);
            std::sort(overlapping.begin(), overlapping.end());
            out[k] = pairs.self(i, overlapping);
        }
    });
    return out;
}

void Exchange::set(std::size_t i, std::size_t j, double value) {
    for (const std::size_t k : {i * size + j, j * size + i})
        if (precise)
            precise[k] = value;
        else
            g[k] = static_cast<float>(value / unit);
}

Exchange exchange_of_all_pairs(const Scene& scene, const Tracer* tracer, const ExchangeOptions& options,
                               std::uint64_t seed, const Progress& progress) {
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    require_memory_for_pairs(n, options.max_memory);
    const PairExchange pairs(scene, options.epsilon, true, options.tuning);

    Exchange out;
    out.g.assign(n * n, 0.0f);
    double total = 0.0;
    for (const double area : s.areas) total += area;
    if (n > 0) out.unit = std::ldexp(1.0, std::ilogb(total / static_cast<double>(n)));
    const auto of_pair = [&](std::uint32_t i, std::uint32_t j, std::size_t& rays) {
        PairExchange::Pair pair = pairs(i, j);
        if (tracer && pair.exchange > 0.0)
            pair.exchange *=
                visible_share(*tracer, pairs, i, j, pair.range, pair.exchange / std::min(s.areas[i], s.areas[j]),
                              pairs.is_patch(i) || pairs.is_patch(j), options.tuning, seed, rays);
        return pair;
    };
    fill_all_pairs(out, scene, pairs, of_pair, progress);
    return out;
}

namespace {

template <class Number>
double row_product(const Number* row, const double* column, std::size_t size) {
    constexpr std::size_t lanes = 8;
    double sum[lanes] = {};
    std::size_t j = 0;
    for (; j + lanes <= size; j += lanes)
        for (std::size_t l = 0; l < lanes; ++l) sum[l] += static_cast<double>(row[j + l]) * column[j + l];
    for (; j < size; ++j) sum[0] += static_cast<double>(row[j]) * column[j];
    double total = 0.0;
    for (double part : sum) total += part;
    return total;
}

}  // namespace

void Exchange::apply(const std::vector<double>& x, std::vector<double>& out, std::size_t channels) const {
    // Channel by channel in memory, so that the inner loop is a plain dot product of a row and a column.
    std::vector<double> columns(channels * size);
    for (std::size_t j = 0; j < size; ++j)
        for (std::size_t c = 0; c < channels; ++c) columns[c * size + j] = scale[j] * x[j * channels + c];
    out.resize(size * channels);
    parallel_for(size, 8, [&](std::size_t i) {
        for (std::size_t c = 0; c < channels; ++c) {
            const double* column = columns.data() + c * size;
            out[i * channels + c] = scale[i] * (precise ? row_product(precise + i * size, column, size)
                                                        : unit * row_product(g.data() + i * size, column, size));
        }
    });
}

std::vector<double> Exchange::row_sums() const {
    std::vector<double> out;
    apply(std::vector<double>(size, 1.0), out, 1);
    return out;
}

}  // namespace surflux
