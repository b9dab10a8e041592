#include "surflux/radiosity/row_block.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/lights/hemisphere_row.h"
#include "surflux/radiosity/nearest_disks.h"

namespace surflux {

namespace {

constexpr std::uint64_t row_stream = 0x5e1ec7;

}  // namespace

RowBlock gather_rows(const Scene& scene, const Tracer& tracer, const std::vector<Place>& places,
                     const std::vector<int>& counts, std::uint64_t seed, const Progress& progress, const Team& team) {
    const SurfelPoints points(scene.surfels);
    const NearestDisks nearest(scene, standing_at(0, places.size(), progress));
    RowBlock out;
    out.rays.assign(counts.begin(), counts.end());
    out.into_backs.assign(places.size(), 0);
    // Each row is written where it would be if all rays met fronts, and moved up afterwards: no second copy.
    std::vector<std::size_t> room(places.size() + 1, 0), found(places.size(), 0);
    for (std::size_t row = 0; row < places.size(); ++row) room[row + 1] = room[row] + out.rays[row];
    out.met.resize(room.back());
    Scratch<HemisphereRow> scratch;
    shared_blocks(
        team, "rays", [&] { return digest_of_rays(seed, places, counts); }, places.size(), 16,
        [&](std::size_t first, std::size_t last) {
            const Scratch<HemisphereRow>::Lent shot(scratch);
            for (std::size_t row = first; row < last; ++row) {
                gather_row(points, tracer, places[row], counts[row], seed + row_stream, *shot);
                std::uint32_t* met = out.met.data() + room[row];
                for (std::size_t k = 0; k < (*shot).hits.size(); ++k) {
                    const Hit& hit = (*shot).hits[k];
                    const Ray& ray = (*shot).rays[k];
                    if (!hit) continue;
                    if (hit.front)
                        met[found[row]++] = nearest.owner(hit.surfel, ray.from.position + hit.distance * ray.direction);
                    else
                        ++out.into_backs[row];
                }
                std::sort(met, met + found[row]);
            }
        },
        [&](std::size_t first, std::size_t last, Packed& to) {
            for (std::size_t row = first; row < last; ++row) {
                to.add(static_cast<std::uint32_t>(found[row]));
                to.add(out.into_backs[row]);
                to.add(out.met.data() + room[row], found[row]);
            }
        },
        [&](std::size_t first, std::size_t last, Unpacking& from) {
            for (std::size_t row = first; row < last; ++row) {
                found[row] = from.take<std::uint32_t>();
                out.into_backs[row] = from.take<std::uint32_t>();
                from.take(out.met.data() + room[row], found[row]);
            }
        },
        progress);
    out.begin.resize(places.size() + 1);
    for (std::size_t row = 0; row < places.size(); ++row) {
        const auto from = out.met.begin() + static_cast<std::ptrdiff_t>(room[row]);
        std::copy(from, from + static_cast<std::ptrdiff_t>(found[row]),
                  out.met.begin() + static_cast<std::ptrdiff_t>(out.begin[row]));
        out.begin[row + 1] = out.begin[row] + found[row];
    }
    out.met.resize(out.begin.back());
    return out;
}

}  // namespace surflux
