#include "surflux/lights/aimed_row.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

// Rings of equal area of the disk below the hemisphere (Malley), and sectors of each.
constexpr int rings = 8, sectors = 32, cells = rings * sectors;
constexpr int fewest = 2, most = 128;  // rays of a cell; powers of 2
constexpr int spread = 4;              // that part of the rays is for all cells alike: what was not aimed at

static_assert(AimedRow::least_rays == fewest * cells);
using OfCell = std::array<double, cells>;

struct Cell {
    int ring, sector;
};

Cell cell_of(const Frame& frame, const Vec3& direction) {
    const double x = dot(direction, frame.u), y = dot(direction, frame.v), turn = std::atan2(y, x) / (2.0 * pi);
    return {std::min(rings - 1, static_cast<int>(rings * (x * x + y * y))),
            static_cast<int>(sectors * (turn < 0.0 ? turn + 1.0 : turn)) % sectors};
}

// Second moments by cell. What is seen from elsewhere stands a little aside: neighbours have a part of it.
OfCell moments(const Frame& frame, const std::vector<Aim>& aims) {
    constexpr double beside[3] = {0.5, 1.0, 0.5};
    OfCell out{};
    for (const Aim& aim : aims) {
        if (!(dot(aim.direction, frame.n) > 0.0) || !(aim.weight > 0.0)) continue;
        const auto [ring, sector] = cell_of(frame, aim.direction);
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j) {
                const int r = ring + i, s = (sector + j + sectors) % sectors;
                if (r >= 0 && r < rings)
                    out[static_cast<std::size_t>(r * sectors + s)] += beside[i + 1] * beside[j + 1] * aim.weight;
            }
    }
    return out;
}

}  // namespace

double AimedRow::density_towards(const Frame& frame, const Vec3& direction) const {
    const auto [ring, sector] = cell_of(frame, direction);
    return density[static_cast<std::size_t>(ring * sectors + sector)];
}

void gather_aimed_row(const SurfelPoints& points, const Tracer& tracer, const Place& place, int count,
                      const std::vector<Aim>& aims, std::uint64_t seed, AimedRow& out) {
    const Frame frame = frame_around(place.normal);
    OfCell wanted = moments(frame, aims);
    double sum = 0.0;
    for (double& m : wanted) sum += m = std::sqrt(m);
    out.found.rays.clear();
    out.units.clear();
    out.first.clear();
    out.density.clear();
    out.unit = cells * most;
    int least = fewest;
    while (2 * least <= most && 2 * least * cells * spread <= count) least *= 2;
    const int dimensions = points.extends(place) ? 4 : 2;
    for (int cell = 0; cell < cells; ++cell) {
        const double share = sum > 0.0 ? wanted[static_cast<std::size_t>(cell)] / sum : 1.0 / cells;
        int rays = least;
        // To the nearest power of 2.
        while (rays < most && rays * std::sqrt(2.0) < share * count) rays *= 2;
        out.density.push_back(static_cast<std::uint32_t>(rays * cells));
        EvenPoints even(dimensions, seed, stream_of(place) * cells + static_cast<std::uint64_t>(cell));
        for (int k = 0; k < rays; ++k) {
            const double* u = even.next();
            const double radius = std::sqrt((cell / sectors + u[0]) / rings);
            const double angle = 2.0 * pi * (cell % sectors + u[1]) / sectors;
            const Vec3 d{radius * std::cos(angle), radius * std::sin(angle),
                         std::sqrt(std::max(0.0, 1.0 - radius * radius))};
            out.found.rays.push_back({{points.at(place, u[2], u[3]), place.normal, place.surfel}, frame.to_world(d)});
            out.units.push_back(static_cast<std::uint16_t>(most / rays));
            out.first.push_back(2 * k < rays);
        }
    }
    tracer.closest(out.found.rays, out.found.hits);
}

}  // namespace surflux
