#include "surflux/trace/side_changes.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double coplanar = 0.8;   // cosine of two normals, but for their signs
constexpr double opposite = 0.5;   // minus the cosine of the ways to those that face alike, and to the others
constexpr double level = 0.9;      // minus the agreement with those: the other side of a fold lies below
constexpr std::size_t fewest = 2;  // neighbours of each kind
// Of a line, over the root of the sheet's surfels: 1 to 2 on houses, a LiDAR tile and statues of 3000 points, half of
// which are turned over, .5 and less on those of 1500. Less is chance, where folds, leaves and crowns are thin.
constexpr double least_line = 0.5;

bool changes_side(const Surfels& s, const SheetSides& sides, std::uint32_t i) {
    Vec3 to_alike, to_others;
    std::size_t alike = 0, others = 0;
    for (const std::uint32_t j : sides.graph[i]) {
        const Vec3 d = s.positions[j] - s.positions[i];
        const double sign = sides.turned(i) == sides.turned(j) ? 1.0 : -1.0;
        const double cosine = sign * dot(s.normals[i], s.normals[j]);
        const double agree = sign * agreement(s.normals[i], s.normals[j], d);
        const Vec3 along = d - dot(d, s.normals[i]) * s.normals[i];
        if (cosine > coplanar && agree > continuation) ++alike, to_alike += along;
        if (cosine < -coplanar && agree < -level) ++others, to_others += along;
    }
    if (alike < fewest || others < fewest) return false;
    return dot(to_alike, to_others) < -opposite * length(to_alike) * length(to_others);
}

}  // namespace

void find_side_changes(const Surfels& s, SheetSides& sides) {
    std::vector<char> on_line(s.size(), 0);
    parallel_for(s.size(), 1024, [&](std::size_t i) {
        if (sides.sheet[i] == SheetSides::none || sides.two_sided[i]) return;
        const OrientedSheet& sheet = sides.sheets[sides.sheet[i]];
        if (sheet.tangled <= most_tangled) return;
        on_line[i] = changes_side(s, sides, static_cast<std::uint32_t>(i));
    });
    std::vector<std::size_t> count(sides.sheets.size(), 0);
    for (std::size_t i = 0; i < s.size(); ++i)
        if (on_line[i]) ++count[sides.sheet[i]];
    sides.unsure.assign(s.size(), false);
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (!on_line[i]) continue;
        const auto size = static_cast<double>(sides.sheets[sides.sheet[i]].size);
        sides.unsure[i] = static_cast<double>(count[sides.sheet[i]]) >= least_line * std::sqrt(size);
    }
}

}  // namespace surflux
