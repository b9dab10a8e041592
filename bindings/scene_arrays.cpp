#include "arrays.h"
#include "rooms.h"

#include "surflux/scene/whole_scene.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux::bindings {

namespace {

// A palette, and where it is short the entry of each in a byte.
void put(py::dict& out, const std::string& name, const Colors& colors) {
    const std::vector<Rgb>& palette = colors.palette();
    std::vector<std::uint8_t> index;
    if (palette.size() <= 256)
        for (const Rgb& color : colors) index.push_back(static_cast<std::uint8_t>(&color - palette.data()));
    out[py::str(name)] = to_array(palette);
    out[py::str(name + "_index")] = to_array(index);
}

Colors take_colors(const py::dict& arrays, const std::string& name) {
    std::vector<Rgb> palette;
    std::vector<std::uint8_t> index;
    take(arrays, name.c_str(), palette);
    take(arrays, (name + "_index").c_str(), index);
    if (palette.size() > 256) return palette;
    Colors out;
    for (const std::uint8_t k : index) {
        require(k < palette.size(), name, "_index: wanted entries of the palette");
        out.push_back(palette[k]);
    }
    return out;
}

void put_shapes(py::dict& out, const Surfels& s) {
    std::vector<Vec3> corners, normals;
    std::vector<double> limits;
    std::vector<std::uint32_t> triangle_surfel, surfels, kinds;
    for (const Triangle& t : s.triangles) {
        corners.insert(corners.end(), {t.a, t.b, t.c});
        triangle_surfel.push_back(t.surfel);
    }
    for (const DiskEnd& end : s.ends) {
        normals.push_back(end.normal);
        limits.push_back(end.limit);
        surfels.push_back(end.surfel);
        kinds.push_back(end.kind);
    }
    out["corners"] = to_array(corners);
    out["triangle_surfel"] = to_array(triangle_surfel);
    out["end_normal"] = to_array(normals);
    out["end_limit"] = to_array(limits);
    out["end_surfel"] = to_array(surfels);
    out["end_kind"] = to_array(kinds);
    out["alone"] = to_array(s.alone);
}

void take_shapes(const py::dict& arrays, Surfels& s) {
    std::vector<Vec3> corners, normals;
    std::vector<double> limits;
    std::vector<std::uint32_t> triangle_surfel, surfels, kinds;
    take(arrays, "corners", corners);
    take(arrays, "triangle_surfel", triangle_surfel);
    require(corners.size() == 3 * triangle_surfel.size(), "corners: wanted three for each triangle");
    for (std::size_t t = 0; t < triangle_surfel.size(); ++t)
        s.triangles.push_back({corners[3 * t], corners[3 * t + 1], corners[3 * t + 2], triangle_surfel[t]});
    take(arrays, "end_normal", normals);
    take(arrays, "end_limit", limits);
    take(arrays, "end_surfel", surfels);
    take(arrays, "end_kind", kinds);
    const std::size_t n = normals.size();
    require(limits.size() == n && surfels.size() == n && kinds.size() == n,
            "end_normal: wanted as many as of all else");
    for (std::size_t k = 0; k < n; ++k)
        s.ends.push_back(
            {normals[k], limits[k], surfels[k], kinds[k] == DiskEnd::crease ? DiskEnd::crease : DiskEnd::border});
    take(arrays, "alone", s.alone);
}

void put_gloss(py::dict& out, const Surfels& s) {
    Colors specular;
    std::vector<double> exponents;
    for (std::size_t i = 0; i < s.size() && !s.gloss.empty(); ++i) {
        if (s.gloss.has_specular()) specular.push_back(s.gloss.specular(i));
        exponents.push_back(s.gloss.exponent(i));
    }
    put(out, "specular", specular);
    out["exponent"] = to_array(exponents);
}

Gloss take_gloss(const py::dict& arrays, std::size_t n) {
    Colors specular = take_colors(arrays, "specular");
    std::vector<double> exponents;
    take(arrays, "exponent", exponents);
    require((specular.empty() || specular.size() == n) && (exponents.empty() || exponents.size() == n),
            "specular: wanted one for each surfel, or none");
    return {std::move(specular), std::move(exponents)};
}

// All that a compiled scene is, but its lights.
py::dict arrays_of(const py::object& self) {
    const Scene& scene = self.cast<const CompiledScene&>().scene();
    const Surfels& s = scene.surfels;
    py::dict out;
    out["positions"] = view_of(s.positions, self);
    out["normals"] = view_of(s.normals, self);
    out["radii"] = view_of(s.radii, self);
    out["areas"] = view_of(s.areas, self);
    put(out, "reflectance", s.reflectance);
    put(out, "emission", s.emission);
    put_gloss(out, s);
    put_shapes(out, s);
    out["object"] = view_of(scene.object, self);
    out["covers"] = view_of(scene.covers, self);
    out["sheets"] = view_of(scene.sheets, self);
    out["spread"] = view_of(scene.spread, self);
    return out;
}

std::shared_ptr<CompiledScene> scene_of(const py::dict& arrays, const std::vector<Light>& lights) {
    Scene scene;
    Surfels& s = scene.surfels;
    take(arrays, "positions", s.positions);
    take(arrays, "normals", s.normals);
    take(arrays, "radii", s.radii);
    take(arrays, "areas", s.areas);
    s.reflectance = take_colors(arrays, "reflectance");
    s.emission = take_colors(arrays, "emission");
    s.gloss = take_gloss(arrays, s.size());
    take_shapes(arrays, s);
    take(arrays, "object", scene.object);
    take(arrays, "covers", scene.covers);
    take(arrays, "sheets", scene.sheets);
    take(arrays, "spread", scene.spread);
    scene.lights = lights;
    return without_gil([&] {
        require_whole(scene);
        return std::make_shared<CompiledScene>(std::move(scene));
    });
}

}  // namespace

void bind_scene_arrays(py::module_& module) {
    PYBIND11_NUMPY_DTYPE(Cover, below, above);
    PYBIND11_NUMPY_DTYPE(Sheet, one, other);
    module.def("scene_arrays", &arrays_of, py::arg("scene"));
    module.def("scene_of_arrays", &scene_of, py::arg("arrays"), py::arg("lights"));
}

}  // namespace surflux::bindings
