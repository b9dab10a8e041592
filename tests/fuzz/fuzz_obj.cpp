#include <cmath>

#include "fuzz.h"
#include "surflux/files/obj.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace surflux;
    const std::string path = "a.obj", bytes(reinterpret_cast<const char*>(data), size);
    fuzz::accepted_or_refused(path, [&] {
        const ObjData obj = parse_obj(path, bytes);
        for (const Vec3& vertex : obj.vertices) fuzz::hold(is_finite(vertex), "coordinates are finite");
        fuzz::hold(obj.colors.empty() || obj.colors.size() == obj.vertices.size(), "all vertices have colours or none");
        fuzz::hold(obj.faces.begin.back() == obj.faces.corners.size(), "faces end at the end");
        fuzz::hold(obj.face_materials.size() == obj.faces.size(), "each face has a material or none");
        for (const std::uint32_t material : obj.face_materials)
            fuzz::hold(material == ObjData::no_material || material < obj.materials.size(), "each material has a name");
        for (std::size_t i = 0; i < obj.faces.size(); ++i)
            fuzz::hold(obj.faces.begin[i] + 3 <= obj.faces.begin[i + 1], "a face has three corners or more");
        const bool has_places = !obj.texture_places.empty();
        fuzz::hold(obj.texture_corners.size() == (has_places ? obj.faces.corners.size() : 0), "corners have places");
        for (const std::uint32_t place : obj.texture_corners)
            fuzz::hold(place == ObjData::no_place || place < obj.texture_places.size(), "each place is there");
        for (const ObjData::TexturePlace& at : obj.texture_places)
            fuzz::hold(std::isfinite(at.u) && std::isfinite(at.v), "places are finite");
        for (const std::uint32_t corner : obj.faces.corners)
            fuzz::hold(corner < obj.vertices.size(), "each corner is a vertex");
    });
    return 0;
}
