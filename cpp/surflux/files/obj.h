#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/files/polygons.h"

namespace surflux {

struct ObjData {
    std::vector<Vec3> vertices;
    std::vector<Rgb> colors;  // the three numbers after x y z; empty unless every vertex has them
    Polygons faces;
    std::vector<std::string> libraries;         // what stands in each line mtllib
    std::vector<std::string> materials;         // and usemtl, in their order
    std::vector<std::uint32_t> face_materials;  // index into materials; no_material before the first
    static constexpr std::uint32_t no_material = 0xffffffff;
};

// The geometry of a Wavefront OBJ file: its lines v and f, polygons of any size, indices from 1 or, relative, from -1;
// and which material each face has. All else is stepped over. Throws FileError with the line.
ObjData read_obj(const std::string& path);

// The same for a file that is in memory already; `path` is for messages.
ObjData parse_obj(const std::string& path, const std::string& bytes);

}  // namespace surflux
