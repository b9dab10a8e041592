#include "surflux/meshless/row_noise.h"

#include <cmath>
#include <memory>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// How many rays a row wants whose standard error is so many times what it may be: evenly spread ones, of which twice
// as many have about 2^-3/4 of the error.
int rays_for(double times, int rays, int most) {
    for (double left = times; left > 1.0 && 2 * rays <= most; left *= 0.6) rays *= 2;
    return rays;
}

}  // namespace

void RowNoise::add(const std::vector<Place>& places, const std::vector<std::uint32_t>& objects,
                   const std::vector<int>& counts, const Progress& progress) {
    std::vector<Vec3> positions, normals;
    for (const Place& place : places) positions.push_back(place.position), normals.push_back(place.normal);
    const Interpolation sites(positions, normals, objects);
    const auto before = static_cast<std::uint32_t>(rows_.size());
    rows_.resize(before + places.size());
    parallel_blocks(
        places.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = begin; k < end; ++k) {
                Row& row = rows_[before + k];
                row.place = places[k];
                row.count = counts[k];
                sites.nearest(positions[k], normals[k], objects[k], Interpolation::most_sites, near);
                for (const Interpolation::Weight& other : near) row.around[row.neighbors++] = before + other.site;
            }
        },
        progress);
}

void RowNoise::find(const std::vector<Rgb>& sent, const std::vector<double>& allowed) {
    std::vector<double> own(rows_.size());
    parallel_for(rows_.size(), 64, [&](std::size_t k) { own[k] = gather_.standard_error(k, sent) / allowed[k]; });
    standard_error_.resize(rows_.size());
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        const Row& row = rows_[k];
        double squared = 0.0;
        for (std::uint32_t i = 0; i < row.neighbors; ++i) squared += own[row.around[i]] * own[row.around[i]];
        standard_error_[k] = allowed[k] * (row.neighbors > 0 ? std::sqrt(squared / row.neighbors) : own[k]);
    }
}

std::vector<HemisphereGather::Shot> RowNoise::wanted(const std::vector<double>& allowed, int most) {
    std::vector<HemisphereGather::Shot> out;
    if (most < AimedRow::least_rays) return out;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        Row& row = rows_[k];
        if (row.is_aimed) continue;
        const int rays = rays_for(standard_error_[k] / allowed[k], row.count, most);
        if (rays == row.count) continue;
        row.is_aimed = true;
        out.push_back({k, row.place, rays});
    }
    return out;
}

HemisphereGather::Aims RowNoise::aims(const std::vector<HemisphereGather::Shot>& rows, const std::vector<Rgb>& sent,
                                      const Progress& progress) const {
    std::vector<char> asked(rows_.size(), 0);
    for (const HemisphereGather::Shot& of : rows)
        for (std::uint32_t i = 0; i < rows_[of.row].neighbors; ++i) asked[rows_[of.row].around[i]] = 1;
    const auto ends = std::make_shared<std::vector<std::vector<HemisphereGather::End>>>(rows_.size());
    parallel_for(
        rows_.size(), 8,
        [&](std::size_t k) {
            if (asked[k]) gather_.ends(rows_[k].place, rows_[k].count, sent, (*ends)[k]);
        },
        progress);
    return [this, ends, &rows](std::size_t k, std::vector<Aim>& out) {
        const Row& row = rows_[rows[k].row];
        for (std::uint32_t i = 0; i < row.neighbors; ++i) {
            const double each = 1.0 / rows_[row.around[i]].count;
            for (const HemisphereGather::End& end : (*ends)[row.around[i]]) {
                const Vec3 way = end.is_sky ? end.at : end.at - row.place.position;
                const double far = length(way);
                if (far > 0.0) out.push_back({way / far, each * end.light * end.light});
            }
        }
    };
}

}  // namespace surflux
