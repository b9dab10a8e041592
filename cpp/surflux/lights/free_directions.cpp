#include "surflux/lights/free_directions.h"

#include <algorithm>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t neighbours = 64;  // surfels of a block
constexpr std::size_t at_once = 1024;   // rays

struct Asked {
    std::uint32_t row, direction;
};

}  // namespace

FreeDirections find_free_directions(const Surfels& surfels, const std::vector<std::uint32_t>& which,
                                    const Tracer& tracer, const std::vector<Vec3>& directions,
                                    const Progress& progress) {
    const std::size_t n = which.size(), bytes = FreeDirections::row_bytes(directions.size());
    FreeDirections out{directions.size(), std::vector<std::uint8_t>(n * bytes, 0)};
    // Packets take 10 to 20 % more time than single rays of one surfel after another among the disks of a LiDAR tile,
    // and 30 to 40 % less among the triangles of Sponza.
    const bool by_sixteen = !surfels.triangles.empty();
    std::vector<Vec3> positions;
    for (const std::uint32_t i : which) positions.push_back(surfels.positions[i]);
    const std::vector<std::uint32_t> order = morton_order(positions, standing_at(0, n, progress));
    const auto of_block = [&](std::size_t begin, std::size_t end) {
        std::vector<Ray> rays;
        std::vector<Asked> asked;
        std::vector<char> free;
        const auto trace = [&] {
            by_sixteen ? tracer.free_coherent(rays, free) : tracer.free(rays, free);
            for (std::size_t r = 0; r < rays.size(); ++r)
                if (free[r] != 0)
                    out.bits[asked[r].row * bytes + asked[r].direction / 8] |=
                        static_cast<std::uint8_t>(0x80u >> (asked[r].direction % 8));
            rays.clear();
            asked.clear();
        };
        const auto ask = [&](std::size_t k, std::size_t j) {
            const std::uint32_t surfel = which[order[k]];
            if (!(dot(surfels.normals[surfel], directions[j]) > 0.0)) return;
            rays.push_back({tracer.on(surfel, positions[order[k]]), directions[j]});
            asked.push_back({order[k], static_cast<std::uint32_t>(j)});
            if (rays.size() == at_once) trace();
        };
        if (by_sixteen) {
            for (std::size_t j = 0; j < directions.size(); ++j)
                for (std::size_t k = begin; k < end; ++k) ask(k, j);
        } else {
            for (std::size_t k = begin; k < end; ++k)
                for (std::size_t j = 0; j < directions.size(); ++j) ask(k, j);
        }
        trace();
    };
    parallel_blocks(n, neighbours, of_block, progress);
    return out;
}

DirectionSums sum_directions(const std::vector<Vec3>& normals, const std::uint8_t* bits,
                             const std::vector<Vec3>& vectors, bool cosine) {
    const std::size_t n = normals.size(), bytes = FreeDirections::row_bytes(vectors.size());
    std::vector<double> lengths;
    for (const Vec3& v : vectors) lengths.push_back(length(v));
    DirectionSums out{std::vector<double>(n, 0.0), std::vector<double>(n, 0.0)};
    parallel_for(n, 1024, [&](std::size_t i) {
        const std::uint8_t* row = bits + i * bytes;
        double arrived = 0.0, all = 0.0;
        for (std::size_t j = 0; j < vectors.size(); ++j) {
            const double facing = dot(normals[i], vectors[j]);
            if (!(facing > 0.0)) continue;
            const double brings = cosine ? facing : lengths[j];
            all += brings;
            if ((row[j / 8] >> (7 - j % 8) & 1) != 0) arrived += brings;
        }
        out.arrived[i] = arrived;
        out.unoccluded[i] = all;
    });
    return out;
}

}  // namespace surflux
