#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/files/polygons.h"

namespace surflux {

struct ObjData {
    std::vector<Vec3> vertices;
    std::vector<Rgb> colors;  // the three numbers after x y z, NaN where a vertex has none; empty where all have none
    Polygons faces;
    std::vector<std::string> libraries;         // what stands in each line mtllib
    std::vector<std::string> materials;         // and usemtl, in their order
    std::vector<std::uint32_t> face_materials;  // index into materials; no_material before the first
    static constexpr std::uint32_t no_material = 0xffffffff;
    // Lines vt, their first two numbers, and of each corner of a face the one that it names: no_place where it names
    // none, or one that is not there. Without any line vt no corner has one, and texture_corners are empty.
    struct TexturePlace {
        float u, v;
    };
    std::vector<TexturePlace> texture_places;
    std::vector<std::uint32_t> texture_corners;
    static constexpr std::uint32_t no_place = 0xffffffff;
};

// The geometry of a Wavefront OBJ file: its lines v and f, polygons of any size, indices from 1 or, relative, from -1;
// which material each face has, and where on its texture corners lie. All else is stepped over. Throws FileError with
// the line.
ObjData read_obj(const std::string& path);

// The same for a file that is in memory already; `path` is for messages.
ObjData parse_obj(const std::string& path, const std::string& bytes);

}  // namespace surflux
