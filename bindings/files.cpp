#include <filesystem>

#include "convert.h"
#include "rooms.h"

#include <pybind11/stl/filesystem.h>

#include "surflux/files/obj.h"
#include "surflux/files/ply.h"

namespace surflux::bindings {

namespace {

// Files hold bytes: UTF-8, or else Latin-1, which any bytes are.
py::str to_text(const std::string& bytes) {
    const auto size = static_cast<py::ssize_t>(bytes.size());
    PyObject* text = PyUnicode_DecodeUTF8(bytes.data(), size, "strict");
    if (!text) {
        PyErr_Clear();
        text = PyUnicode_DecodeLatin1(bytes.data(), size, "strict");
    }
    if (!text) throw py::error_already_set();
    return py::reinterpret_steal<py::str>(text);
}

py::list to_texts(const std::vector<std::string>& lines) {
    py::list out;
    for (const std::string& line : lines) out.append(to_text(line));
    return out;
}

py::list to_bytes(const std::vector<std::string>& names) {
    py::list out;
    for (const std::string& name : names) out.append(py::bytes(name));
    return out;
}

py::array_t<std::int64_t> offsets_of(const std::vector<std::size_t>& begin) {
    return to_array(std::vector<std::int64_t>(begin.begin(), begin.end()));
}

py::dict read_ply_file(const std::filesystem::path& path, const std::vector<std::string>& keep) {
    const PlyData data = without_gil([&] { return read_ply(path.string(), keep); });
    py::dict elements, columns, types;
    for (const PlyElement& element : data.elements) {
        const py::str name = to_text(element.name);
        elements[name] = element.count;
        py::dict values, names;
        for (const PlyColumn& column : element.columns) {
            values[to_text(column.name)] = to_array(column.values);
            names[to_text(column.name)] = name_of(column.type);
        }
        columns[name] = values;
        types[name] = names;
    }
    py::dict out;
    out["elements"] = elements;
    out["columns"] = columns;
    out["types"] = types;
    out["face_offsets"] = offsets_of(data.faces.begin);
    out["face_indices"] = to_array(data.faces.corners);
    out["face_texcoord"] = py::make_tuple(offsets_of(data.texcoord.begin), to_array(data.texcoord.values));
    out["comments"] = to_texts(data.comments);
    out["object_info"] = to_texts(data.object_info);
    return out;
}

py::tuple read_obj_file(const std::filesystem::path& path) {
    const ObjData data = without_gil([&] { return read_obj(path.string()); });
    const py::object colors = data.colors.empty() ? py::object(py::none()) : py::object(to_array(data.colors));
    const py::tuple materials =
        py::make_tuple(to_bytes(data.libraries), to_bytes(data.materials), to_array(data.face_materials));
    std::vector<float> places;
    for (const ObjData::TexturePlace& at : data.texture_places) places.insert(places.end(), {at.u, at.v});
    return py::make_tuple(to_array(data.vertices), offsets_of(data.faces.begin), to_array(data.faces.corners), colors,
                          materials, py::make_tuple(to_array(places), to_array(data.texture_corners)));
}

using NamedColumn = std::tuple<std::string, std::string, Doubles>;
using NamedElement = std::tuple<std::string, std::size_t, std::vector<NamedColumn>>;
using Offsets = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

void write_ply_file(const std::filesystem::path& path, const std::vector<NamedElement>& elements,
                    const std::optional<std::pair<Offsets, Indices>>& faces, const std::vector<std::string>& comments) {
    std::vector<PlyElement> rows;
    for (const auto& [name, count, columns] : elements) {
        rows.push_back({name, count, {}});
        for (const auto& [column, type, values] : columns)
            rows.back().columns.push_back({column, ply_type(type), to_vector(values)});
    }
    Polygons polygons;
    if (faces) {
        const auto& [offsets, indices] = *faces;
        require(offsets.size() > 0, "faces: wanted one more offset than faces");
        polygons.begin.assign(offsets.data(), offsets.data() + offsets.size());
        polygons.corners = to_vector(indices);
    }
    py::gil_scoped_release release;
    write_ply(path.string(), rows, polygons, comments);
}

}  // namespace

void bind_files(py::module_& module) {
    module.def(
        "read_ply", &read_ply_file, py::arg("path"), py::arg("keep") = std::vector<std::string>{"vertex", "face"},
        "Columns by element and name (float64), their types, face corners as offsets and indices, texcoord of faces "
        "as offsets and numbers, comments.");
    module.def(
        "read_obj", &read_obj_file, py::arg("path"),
        "(vertices, face offsets, face indices, vertex colors, NaN for none, or None, (libraries, names, name of "
        "each face), the first two in bytes, (u v of each place on a texture, place of each index: empty without "
        "any))");
    module.def("write_ply", &write_ply_file, py::arg("path"), py::arg("elements"), py::arg("faces") = py::none(),
               py::arg("comments") = std::vector<std::string>{},
               "elements: [(name, rows, [(column, type, values)])]; faces: (offsets, indices) of the element face.");
}

}  // namespace surflux::bindings
