#include <cmath>

#include "fuzz.h"
#include "surflux/files/ply.h"

namespace surflux::fuzz {
namespace {

// What ply.h promises of data that it gives.
void check(const PlyData& data) {
    const PlyElement* vertex = data.find("vertex");
    for (const PlyElement& element : data.elements)
        for (const PlyColumn& column : element.columns) {
            hold(column.values.size() == element.count, "a column has one value per row");
            if (&element != vertex || (column.name != "x" && column.name != "y" && column.name != "z")) continue;
            for (const double value : column.values) hold(std::isfinite(value), "coordinates are finite");
        }
    hold(data.faces.begin.front() == 0 && data.faces.begin.back() == data.faces.corners.size(), "faces end at the end");
    for (std::size_t i = 0; i < data.faces.size(); ++i)
        hold(data.faces.begin[i] <= data.faces.begin[i + 1], "faces follow each other");
    hold(data.texcoord.begin.back() == data.texcoord.values.size(), "texcoord ends at the end");
    for (const std::uint32_t corner : data.faces.corners)
        hold(vertex && corner < vertex->count, "each corner is a vertex");
}

}  // namespace
}  // namespace surflux::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace surflux;
    const std::string path = "a.ply", bytes(reinterpret_cast<const char*>(data), size);
    // As meshes and as points are read.
    fuzz::accepted_or_refused(path, [&] { fuzz::check(parse_ply(path, bytes)); });
    fuzz::accepted_or_refused(path, [&] { fuzz::check(parse_ply(path, bytes, {"vertex", "patch"})); });
    return 0;
}
