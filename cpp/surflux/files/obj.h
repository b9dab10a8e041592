#pragma once

#include <string>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/files/polygons.h"

namespace surflux {

struct ObjData {
    std::vector<Vec3> vertices;
    std::vector<Rgb> colors;  // the three numbers after x y z; empty unless every vertex has them
    Polygons faces;
};

// The geometry of a Wavefront OBJ file: its lines v and f, polygons of any size, indices from 1 or, relative, from -1.
// All else is stepped over. Throws FileError with the line.
ObjData read_obj(const std::string& path);

}  // namespace surflux
