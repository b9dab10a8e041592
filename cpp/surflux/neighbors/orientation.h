#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// How well unit normals n and m of points that are d apart continue each other: 1 where they do, -1 where one of them
// has to be turned, 0 where nothing can be said. m is mirrored at the plane halfway, which the normals of an arc obey
// exactly (Xie, Wang, Hua, Qin and Kaufman 2003): so the two sides of a crease agree, and so do the two sheets of a
// thin plate, which face opposite ways.
double agreement(const Vec3& n, const Vec3& m, const Vec3& d);

// Whether the mirror alone has normals of that agreement agree, or not, which is doubtful: without it they say the
// opposite on two thin sheets, but also where noise has put one point above another. Not at creases of about 90
// degrees, where without it they say nothing.
bool mirror_decides(double agreement, double cosine);

// A link of two neighbours, d apart, in the spanning tree of orient_sheets: 1 - |agreement| and a little of the
// distance, over the sum of their spacings.
struct TreeLink {
    double agree, weight;
    bool is_doubtful;  // mirroring decides

    TreeLink(const Vec3& n, const Vec3& m, const Vec3& d, double spacings);
};

using NeighborGraph = std::vector<std::vector<std::uint32_t>>;

// Turns unit normals so that neighbours agree: along a minimum spanning tree of the neighbour graph (Hoppe et al. 1992,
// sec. 3.3). Where `least` is above 0, links with an |agreement| below it do not count, nor do those for which
// mirroring decides. Returns for each place a number that all places of its tree have in common, and no others; which
// way a tree as a whole faces is chance. `spacing`, per place: the distance to a near neighbour.
std::vector<std::uint32_t> orient_sheets(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                                         const NeighborGraph& graph, double least, std::vector<Vec3>& normals,
                                         const Progress& progress = {});

// The same, all links counted, and each tree turned outwards: the sum of area times d . n over it is positive, d the
// direction from its median. (On a closed surface the integral is that of div d = 2 / distance over the volume.)
void orient_consistently(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                         const NeighborGraph& graph, std::vector<Vec3>& normals, const Progress& progress = {});

// The places in groups of one number each, by the number's first appearance.
std::vector<std::vector<std::uint32_t>> groups_of(const std::vector<std::uint32_t>& numbers);

}  // namespace surflux
