#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surflux/files/polygons.h"

namespace surflux {

// The scalar types of PLY (Turk 1994). In a file each goes by two names: char or int8, ..., double or float64.
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

const char* name_of(PlyType type);  // the first name: char, uchar, short, ushort, int, uint, float, double
PlyType ply_type(const std::string& name);
std::size_t size_of(PlyType type);
bool is_integer(PlyType type);
bool fits(double value, PlyType type);  // an integer type holds it exactly; float types hold anything

// A scalar property of an element. All types fit a double exactly.
struct PlyColumn {
    std::string name;
    PlyType type = PlyType::float32;
    std::vector<double> values;
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyColumn> columns;
};

// Numbers of rows: those of row i are values[begin[i]] ... values[begin[i + 1] - 1].
struct PlyLists {
    std::vector<std::size_t> begin{0};
    std::vector<double> values;
};

struct PlyData {
    std::vector<PlyElement> elements;  // all that the header names, in order; columns only of those asked for
    Polygons faces;                    // vertex_indices or vertex_index of `face`
    PlyLists texcoord;                 // of `face`: u v of each corner
    std::vector<std::string> comments;
    std::vector<std::string> object_info;

    const PlyElement* find(const std::string& element) const;
};

// Reads ascii and binary PLY of either byte order. Of the elements in `keep` the scalar properties come back, of `face`
// the polygons and texcoord too; everything else is stepped over. No count of the header is believed before the bytes
// are there. Throws FileError where anything is wrong: also for coordinates x, y, z of a vertex that are not finite and
// for face corners that are no vertex.
PlyData read_ply(const std::string& path, const std::vector<std::string>& keep = {"vertex", "face"});

// The same for a file that is in memory already; `path` is for messages.
PlyData parse_ply(const std::string& path, const std::string& bytes,
                  const std::vector<std::string>& keep = {"vertex", "face"});

// Writes binary little endian. Columns are rounded to their type; integers must fit theirs. `faces` belong to the
// element named face, which must then be there with as many rows. The file appears whole or not at all: it is written
// beside `path` and renamed. Throws ArgumentError for what PLY cannot hold, FileError for what the disk cannot.
void write_ply(const std::string& path, const std::vector<PlyElement>& elements, const Polygons& faces,
               const std::vector<std::string>& comments);

}  // namespace surflux
