#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Tangent-disk radii that leave no gaps between surfels, with as little overlap as follows from the points around each:
// 1.1 times the least radii with which every triangle of the local Delaunay triangulation in the tangent plane is
// covered by the disks of its own three corners, each its nearest part (see tangent_cell.h). In an acute triangle that
// is its circumradius: disks of the covering radius, to the corners of Voronoi cells (Conway and Sloane 1999, Sphere
// Packings, Lattices and Groups, chapter 2), but a point's own, so that they follow the density. On borders, where
// cells are open, disks reach half way to the neighbours. Cells are open, too, where only another piece across a gap
// closes them, by how dense the points of the surface are, or what is seen far below or above: a roof's disks end at
// the street. The distance to the k-th neighbour, which is usual, leaves gaps where points are uneven, or overlaps
// three times as much.
//
// With normals, the disks lie in their planes, and each side of a thin sheet covers itself: neighbours that face the
// other way do not count, unless that makes a disk more than 1.5 times what is usual around. Without, the planes are
// fitted to the points around. Duplicates count once, and a point never counts as its own neighbour. A point far off
// all others, such as scans have, would get a disk that hides them, and points on the rim of a hole disks that close
// it: no radius is more than 2.5 times what is usual around, the third smallest of its six nearest neighbours'.
std::vector<double> estimate_radii(const std::vector<Vec3>& points, const std::vector<Vec3>& normals = {},
                                   const Progress& progress = {});

}  // namespace surflux
