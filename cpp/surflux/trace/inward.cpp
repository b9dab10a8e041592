#include "surflux/trace/inward.h"

#include <algorithm>

#include "surflux/trace/sheet_sides.h"

namespace surflux {

Inward inward_patches(const Surfels& surfels, const InwardOptions& options, const Progress& progress) {
    Inward out;
    out.patch.assign(surfels.size(), 0);
    out.unsure.assign(surfels.size(), 0);
    if (surfels.size() < std::max<std::size_t>(options.smallest, 2)) return out;
    SheetOptions asked;
    asked.smallest = options.smallest;
    asked.rays = options.rays;
    asked.seed = options.seed;
    SheetSides sides = sheet_sides(surfels, asked, progress);
    if (options.rooms)
        for (OrientedSheet& sheet : sides.sheets) sheet.backwards = false;
    std::vector<bool> inward(surfels.size());
    for (std::size_t i = 0; i < surfels.size(); ++i) inward[i] = sides.turned(i), out.unsure[i] = sides.unsure[i];
    std::vector<std::vector<std::uint32_t>> patches = patches_of(surfels, sides.graph, inward);
    std::stable_sort(patches.begin(), patches.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    for (std::size_t k = 0; k < patches.size() && patches[k].size() >= options.smallest; ++k)
        for (std::uint32_t i : patches[k]) out.patch[i] = static_cast<std::uint32_t>(k + 1);
    return out;
}

}  // namespace surflux
