#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/pair_exchange.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct ExchangeOptions {
    double epsilon = 0.8;     // same surface where n_i . n_j is above this, D04 eq. 10
    double max_memory = 0.0;  // bytes for the exchange of all pairs; 0: three quarters of available_memory()
    PairsTuning tuning;
};

// The exchange of light between all pairs of surfels: G_ij = A_i F_ij V_ij, symmetric, G_ii >= 0, stored in full so
// that a product reads it in order. What closes it is kept apart: F_ij = scale_i G_ij scale_j / A_i.
struct Exchange {
    std::size_t size = 0;
    std::vector<float> g;       // size x size, row-major, in `unit`
    double unit = 1.0;          // a power of 2 near the surfels' area, so that floats carry g in any unit of length
    double* precise = nullptr;  // in place of g: as many doubles, which somebody else keeps
    std::vector<double> areas;
    std::vector<double> scale;  // 1 until close() finds the diagonal (closure.h)
    std::vector<char> sure;     // per row: a patch's, exact but for what blocks it; a disk's is known to some per cent
    // Pairs i < j at Range::near of which one at least is a disk, in ascending order.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> near;
    std::size_t links = 0;  // pairs i < j that exchange anything
    std::size_t rays = 0;

    double at(std::size_t i, std::size_t j) const {
        return precise ? precise[i * size + j] : unit * static_cast<double>(g[i * size + j]);
    }
    // Both of G_ij and G_ji.
    void set(std::size_t i, std::size_t j, double value);

    // out_i = scale_i sum_j G_ij scale_j x_j for each of `channels` interleaved channels.
    void apply(const std::vector<double>& x, std::vector<double>& out, std::size_t channels) const;
    // The same of x = 1.
    std::vector<double> row_sums() const;
};

// G_ii of all surfels, from the disks that overlap each.
std::vector<double> self_exchanges(const Scene& scene, const PairExchange& pairs);

// Throws ArgumentError where the exchange of n surfels needs more than `limit` bytes (0: as ExchangeOptions says).
void require_memory_for_pairs(std::size_t n, double limit);

// Without a tracer every pair sees each other.
Exchange exchange_of_all_pairs(const Scene& scene, const Tracer* tracer, const ExchangeOptions& options,
                               std::uint64_t seed, const Progress& progress = {});

}  // namespace surflux
