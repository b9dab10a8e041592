#include "surflux/render/creases.h"

#include <algorithm>
#include <map>

#include "surflux/area/disk_ends.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr double farthest = 4.0;  // radii

}  // namespace

std::vector<Creases> creases_of(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                                const std::vector<std::uint32_t>& asked, const std::vector<std::uint32_t>& around) {
    std::vector<Creases> out(asked.size());
    if (asked.empty()) return out;
    std::vector<Vec3> places;
    for (const std::uint32_t i : around) places.push_back(surfels.positions[i]);
    const PointIndex index(places);
    std::vector<char> wanted(around.size(), 0);  // what the disks asked for may overlap
    std::vector<Neighbor> near;
    for (const std::uint32_t i : asked) {
        near.clear();
        index.within(surfels.positions[i], farthest * surfels.radii[i], near);
        for (const Neighbor& n : near) wanted[n.index] = 1;
    }
    std::map<std::int32_t, std::vector<std::uint32_t>> of_object;
    for (std::size_t k = 0; k < around.size(); ++k)
        if (wanted[k]) of_object[objects[around[k]]].push_back(around[k]);
    std::vector<Creases> found(surfels.size());
    for (const auto& [object, members] : of_object) {
        Surfels part = select(surfels, members);
        part.ends.clear();
        for (const DiskEnd& end : find_disk_ends(part).ends) {
            if (end.kind != DiskEnd::crease) continue;
            Creases& creases = found[members[end.surfel]];
            Crease& farther = creases[0].limit > creases[1].limit ? creases[0] : creases[1];
            if (end.limit < farther.limit) farther = {end.normal, end.limit};
        }
    }
    for (std::size_t k = 0; k < asked.size(); ++k) out[k] = found[asked[k]];
    return out;
}

}  // namespace surflux
