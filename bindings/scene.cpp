#include "convert.h"
#include "rooms.h"

#include "surflux/area/compile_scene.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/photometric_web.h"
#include "surflux/scene/divided_patches.h"
#include "surflux/scene/polygon_values.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux::bindings {

namespace {

Surfels make_surfels(const Doubles& positions, const Doubles& normals, const Doubles& radii,
                     const std::optional<Doubles>& areas, const Doubles& reflectance, const Doubles& emission,
                     const Doubles& triangles, const Indices& triangle_surfel, const std::optional<Doubles>& specular,
                     const std::optional<Doubles>& exponent) {
    Surfels s;
    s.positions = to_vec3s(positions, "positions");
    s.normals = to_vec3s(normals, "normals");
    s.radii = to_vector(radii);
    if (areas) s.areas = to_vector(*areas);
    s.reflectance = to_vec3s(reflectance, "reflectance");
    s.emission = to_vec3s(emission, "emission");
    const std::size_t n = s.size();
    require(s.normals.size() == n && s.radii.size() == n && s.reflectance.size() == n && s.emission.size() == n &&
                (s.areas.empty() || s.areas.size() == n),
            "surfels: arrays of different lengths");
    const std::vector<Vec3> gloss = specular ? to_vec3s(*specular, "specular") : std::vector<Vec3>{};
    const std::vector<double> exponents = exponent ? to_vector(*exponent) : std::vector<double>{};
    require((gloss.empty() || gloss.size() == n) && (exponents.empty() || exponents.size() == n),
            "surfels: arrays of different lengths");
    s.gloss = Gloss(gloss, exponents);
    require(triangles.size() == 9 * triangle_surfel.size(), "triangles: wanted shape (t, 3, 3) for t surfel indices");
    const auto* corners = reinterpret_cast<const Vec3*>(triangles.data());
    for (py::ssize_t t = 0; t < triangle_surfel.size(); ++t) {
        const std::uint32_t surfel = triangle_surfel.data()[t];
        require(surfel < n && (t == 0 || surfel >= s.triangles.back().surfel),
                "triangle_surfel: wanted ascending indices of surfels");
        s.triangles.push_back({corners[3 * t], corners[3 * t + 1], corners[3 * t + 2], surfel});
    }
    return s;
}

py::array_t<double> specular_of(const Surfels& s) {
    std::vector<Vec3> out(s.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = s.gloss.specular(i);
    return to_array(out);
}

py::array_t<double> exponents_of(const Surfels& s) {
    std::vector<double> out(s.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = s.gloss.exponent(i);
    return to_array(out);
}

py::array_t<double> triangles_of(const Surfels& s) {
    py::array_t<double> out({static_cast<py::ssize_t>(s.triangles.size()), py::ssize_t{3}, py::ssize_t{3}});
    auto* corner = reinterpret_cast<Vec3*>(out.mutable_data());
    for (const Triangle& t : s.triangles) {
        *corner++ = t.a;
        *corner++ = t.b;
        *corner++ = t.c;
    }
    return out;
}

py::array_t<std::uint32_t> triangle_surfels_of(const Surfels& s) {
    py::array_t<std::uint32_t> out(static_cast<py::ssize_t>(s.triangles.size()));
    for (std::size_t t = 0; t < s.triangles.size(); ++t) out.mutable_data()[t] = s.triangles[t].surfel;
    return out;
}

using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

// (t, ..., d): of values (k, d) at the corners of polygons, at points (t, ..., 3) of polygons (t,). Corners are those
// of a mesh that has been checked.
py::array_t<double> polygon_values(const Doubles& vertices, const Integers& offsets, const Integers& indices,
                                   const Doubles& values, const Integers& polygon, const Doubles& points) {
    const py::ssize_t count = polygon.size(), polygons = offsets.size() - 1;
    require(polygons >= 0 && values.ndim() == 2 && values.shape(0) == indices.size() &&
                offsets.data()[polygons] == indices.size(),
            "values: wanted one for each corner");
    require(points.ndim() >= 2 && points.shape(0) == count && points.shape(points.ndim() - 1) == 3,
            "points: wanted shape (t, ..., 3) for t polygons");
    for (py::ssize_t k = 0; k < count; ++k)
        require(polygon.data()[k] >= 0 && polygon.data()[k] < polygons, "polygon: wanted one of the mesh");
    std::vector<py::ssize_t> shape(points.shape(), points.shape() + points.ndim());
    shape.back() = values.shape(1);
    py::array_t<double> out(shape);
    const PolygonValues of{reinterpret_cast<const Vec3*>(vertices.data()), offsets.data(), indices.data(),
                           values.data(), static_cast<std::size_t>(values.shape(1))};
    const auto rows = static_cast<std::size_t>(count);
    const std::size_t each = rows == 0 ? 0 : static_cast<std::size_t>(points.size() / 3) / rows;
    const auto* at = reinterpret_cast<const Vec3*>(points.data());
    const std::int64_t* which = polygon.data();
    double* to = out.mutable_data();
    without_gil([&] {
        parallel_for(rows, 1024, [&](std::size_t k) {
            of.at(static_cast<std::size_t>(which[k]), at + k * each, each, to + k * each * of.width);
        });
    });
    return out;
}

// All that Surfels are, as arrays: what pickle keeps.
py::tuple state_of(const Surfels& s) {
    std::vector<Vec3> end_normals;
    std::vector<double> limits;
    std::vector<std::uint32_t> owners, kinds;
    for (const DiskEnd& end : s.ends) {
        end_normals.push_back(end.normal);
        limits.push_back(end.limit);
        owners.push_back(end.surfel);
        kinds.push_back(end.kind);
    }
    return py::make_tuple(to_array(s.positions), to_array(s.normals), to_array(s.radii), to_array(s.areas),
                          to_array(s.reflectance), to_array(s.emission), triangles_of(s), triangle_surfels_of(s),
                          to_array(end_normals), to_array(limits), to_array(owners), to_array(kinds), to_array(s.alone),
                          specular_of(s), exponents_of(s));
}

Surfels from_state(const py::tuple& state) {
    require(state.size() == 15, "surfels: a pickle of another version");
    const auto doubles = [&](std::size_t k) { return state[k].cast<Doubles>(); };
    const auto indices = [&](std::size_t k) { return state[k].cast<Indices>(); };
    Surfels s = make_surfels(doubles(0), doubles(1), doubles(2), doubles(3), doubles(4), doubles(5), doubles(6),
                             indices(7), doubles(13), doubles(14));
    const std::vector<Vec3> normals = to_vec3s(doubles(8), "ends");
    const std::vector<double> limits = to_vector(doubles(9));
    const std::vector<std::uint32_t> owners = to_vector(indices(10)), kinds = to_vector(indices(11));
    const std::size_t m = normals.size();
    require(limits.size() == m && owners.size() == m && kinds.size() == m, "ends: arrays of different lengths");
    for (std::size_t k = 0; k < m; ++k) {
        require(owners[k] < s.size() && (k == 0 || owners[k] >= owners[k - 1]), "ends: wanted ascending surfels");
        s.ends.push_back(
            {normals[k], limits[k], owners[k], kinds[k] == DiskEnd::crease ? DiskEnd::crease : DiskEnd::border});
    }
    s.alone = to_vector(indices(12));
    for (const std::uint32_t i : s.alone) require(i < s.size(), "alone: wanted indices of surfels");
    return s;
}

FlatPolygons to_polygons(const Doubles& corners, const py::array_t<std::int64_t>& offsets, const char* name) {
    FlatPolygons out;
    out.corners = to_vec3s(corners, name);
    out.begin.resize(static_cast<std::size_t>(offsets.size()));
    for (py::ssize_t k = 0; k < offsets.size(); ++k)
        out.begin[static_cast<std::size_t>(k)] = static_cast<std::size_t>(offsets.at(k));
    require(!out.begin.empty() && out.begin.front() == 0 && out.begin.back() == out.corners.size(), name,
            ": wanted offsets from 0 to the number of corners");
    for (std::size_t k = 1; k < out.begin.size(); ++k)
        require(out.begin[k] >= out.begin[k - 1] + 3, name, ": wanted 3 corners or more");
    return out;
}

}  // namespace

void bind_scene(py::module_& module) {
    py::class_<Surfels>(module, "Surfels")
        .def(py::init(&make_surfels), py::arg("positions"), py::arg("normals"), py::arg("radii"), py::arg("areas"),
             py::arg("reflectance"), py::arg("emission"), py::arg("triangles"), py::arg("triangle_surfel"),
             py::arg("specular") = py::none(), py::arg("exponent") = py::none())
        .def("__len__", &Surfels::size)
        .def_property_readonly("positions", [](const Surfels& s) { return to_array(s.positions); })
        .def_property_readonly("normals", [](const Surfels& s) { return to_array(s.normals); })
        .def_property_readonly("radii", [](const Surfels& s) { return to_array(s.radii); })
        .def_property_readonly("areas",
                               [](const Surfels& s) -> py::object {
                                   if (s.areas.empty()) return py::none();
                                   return to_array(s.areas);
                               })
        .def_property_readonly("reflectance", [](const Surfels& s) { return to_array(s.reflectance); })
        .def_property_readonly("emission", [](const Surfels& s) { return to_array(s.emission); })
        .def_property_readonly("specular", &specular_of)
        .def_property_readonly("exponent", &exponents_of)
        .def_property_readonly("has_specular", [](const Surfels& s) { return s.gloss.has_specular(); })
        .def_property_readonly("has_gloss", [](const Surfels& s) { return !s.gloss.empty(); })
        .def_property_readonly("triangles", &triangles_of)
        .def_property_readonly("triangle_surfel", &triangle_surfels_of)
        // Copies all: nothing of Surfels ever changes, and passes read them without the GIL.
        .def("with_areas",
             [](const Surfels& s, const Doubles& areas) {
                 std::vector<double> given = to_vector(areas);
                 require(given.empty() || given.size() == s.size(), "areas: wanted one for each surfel, or none");
                 return without_gil([&] {
                     Surfels out = s;
                     out.areas = std::move(given);
                     return out;
                 });
             })
        .def("with_reflectance",
             [](const Surfels& s, const Doubles& reflectance) {
                 std::vector<Vec3> given = to_vec3s(reflectance, "reflectance");
                 require(given.size() == s.size(), "reflectance: wanted one for each surfel");
                 return without_gil([&] {
                     Surfels out = s;
                     out.reflectance = std::move(given);
                     return out;
                 });
             })
        .def("select",
             [](const Surfels& s, const Indices& indices) {
                 const std::vector<std::uint32_t> kept = to_vector(indices);
                 for (const std::uint32_t i : kept) require(i < s.size(), "indices: wanted those of surfels");
                 return without_gil([&] { return select(s, kept); });
             })
        .def("two_sided", [](const Surfels& s) { return without_gil([&] { return two_sided(s); }); })
        .def(py::pickle(&state_of, &from_state));

    py::class_<PointLight>(module, "PointLight").def(py::init([](const Doubles& position, const Doubles& intensity) {
        return PointLight{to_vec3(position, "position"), to_vec3(intensity, "intensity")};
    }));
    py::class_<SpotLight>(module, "SpotLight")
        .def(py::init([](const Doubles& position, const Doubles& direction, const Doubles& intensity, double cone,
                         double penumbra) {
            return SpotLight{to_vec3(position, "position"), to_vec3(direction, "direction"),
                             to_vec3(intensity, "intensity"), cone, penumbra};
        }));
    py::class_<PhotometricLight>(module, "PhotometricLight")
        .def(py::init([](const Doubles& position, const Doubles& direction, const Doubles& zero_plane,
                         const Doubles& intensity, const Doubles& planes, const Doubles& angles, const Doubles& table) {
            require(planes.size() > 1 && angles.size() > 1 && table.size() == planes.size() * angles.size(),
                    "table: wanted one value for each plane and angle, two of each at least");
            return PhotometricLight{to_vec3(position, "position"),
                                    to_vec3(direction, "direction"),
                                    to_vec3(zero_plane, "zero_plane"),
                                    to_vec3(intensity, "intensity"),
                                    to_vector(planes),
                                    to_vector(angles),
                                    to_vector(table)};
        }))
        .def("shares", [](const PhotometricLight& light, const Doubles& directions) {
            const std::vector<Vec3> ways = to_vec3s(directions, "directions");
            const PhotometricWeb web(light);
            std::vector<double> out;
            for (const Vec3& way : ways) out.push_back(web.share(way));
            return to_array(out);
        });
    py::class_<AreaLight>(module, "AreaLight")
        .def(py::init([](const Doubles& corner, const Doubles& u, const Doubles& v, const Doubles& exitance) {
            return AreaLight{to_vec3(corner, "corner"), to_vec3(u, "edge_u"), to_vec3(v, "edge_v"),
                             to_vec3(exitance, "exitance")};
        }));
    py::class_<DirectionalLight>(module, "DirectionalLight")
        .def(py::init([](const Doubles& direction, const Doubles& irradiance) {
            return DirectionalLight{to_vec3(direction, "direction"), to_vec3(irradiance, "irradiance")};
        }));
    py::class_<Environment>(module, "Environment")
        .def(py::init(
                 [](const Doubles& radiance, const std::optional<Doubles>& pixels, const Doubles& up, double azimuth) {
                     Environment e;
                     e.radiance = to_vec3(radiance, "radiance");
                     e.up = to_vec3(up, "up");
                     e.azimuth = azimuth;
                     if (pixels) {
                         require(pixels->ndim() == 3 && pixels->shape(2) == 3, "image: wanted shape (h, w, 3)");
                         e.height = static_cast<std::size_t>(pixels->shape(0));
                         e.width = static_cast<std::size_t>(pixels->shape(1));
                         const auto* first = reinterpret_cast<const Rgb*>(pixels->data());
                         e.pixels.assign(first, first + e.width * e.height);
                     }
                     return e;
                 }),
             py::arg("radiance"), py::arg("pixels"), py::arg("up"), py::arg("azimuth"))
        .def_property_readonly("axes", [](const Environment& e) {
            const Frame frame = EnvironmentMap(e).frame();
            return to_array(std::vector<Vec3>{frame.u, frame.v, frame.n});
        });

    // What of a scene coincides, found by compile_scene.
    py::class_<Coincidence>(module, "Coincidence")
        .def_property_readonly("uncovered", [](const Coincidence& c) { return to_array(c.uncovered); })
        .def_property_readonly("covers",
                               [](const Coincidence& c) {
                                   py::list out;
                                   for (const Cover& of : c.covers) out.append(py::make_tuple(of.below, of.above));
                                   return out;
                               })
        .def_property_readonly("overlaps",
                               [](const Coincidence& c) {
                                   py::list out;
                                   for (const Overlap& o : c.disks.overlaps)
                                       out.append(py::make_tuple(o.one, o.other, o.joined, o.layered, o.height));
                                   return out;
                               })
        .def_property_readonly("coarse",
                               [](const Coincidence& c) {
                                   py::list out;
                                   for (const Coarse& of : c.coarse)
                                       out.append(py::make_tuple(of.object, of.surfels, of.contact));
                                   return out;
                               })
        .def_property_readonly("unlike_areas",
                               [](const Coincidence& c) {
                                   py::list out;
                                   for (const UnlikeAreas& of : c.unlike_areas)
                                       out.append(py::make_tuple(of.object, of.ratio));
                                   return out;
                               })
        .def_property_readonly("gaps",
                               [](const Coincidence& c) {
                                   py::list out;
                                   for (const NarrowGap& gap : c.gaps)
                                       out.append(py::make_tuple(gap.one, gap.other, gap.area, gap.width));
                                   return out;
                               })
        .def_property_readonly("close_sheets", [](const Coincidence& c) {
            py::list out;
            for (const CloseSheet& s : c.close_sheets)
                out.append(py::make_tuple(s.mesh, s.other, s.points, s.area, s.share, s.height));
            return out;
        });

    // Objects as they are. Areas must be given for all or for none.
    py::class_<CompiledScene, std::shared_ptr<CompiledScene>>(module, "Scene")
        .def(py::init([](const std::vector<const Surfels*>& objects, const std::vector<Light>& lights) {
                 return without_gil([&] {
                     Scene scene;
                     for (const Surfels* object : objects) append(scene, *object);
                     scene.lights = lights;
                     return std::make_shared<CompiledScene>(std::move(scene));
                 });
             }),
             py::arg("objects"), py::arg("lights"))
        .def_property_readonly("surfels", [](const CompiledScene& s) -> const Surfels& { return s.scene().surfels; })
        .def_property_readonly("object", [](const CompiledScene& s) { return to_array(s.scene().object); });
    module.def(
        "compile_scene",
        [](const std::vector<const Surfels*>& objects, const std::vector<Light>& lights, const py::object& progress) {
            const Progress report = to_progress(progress);
            Coincidence coincidence;
            auto scene = without_gil(
                [&] { return std::make_shared<CompiledScene>(compile_scene(objects, lights, coincidence, report)); });
            return std::make_pair(std::move(scene), std::move(coincidence));
        },
        py::arg("objects"), py::arg("lights"), py::arg("progress") = py::none());
    module.def("polygon_values", &polygon_values, py::arg("vertices"), py::arg("offsets"), py::arg("indices"),
               py::arg("values"), py::arg("polygon"), py::arg("points"));
    // Corners, offsets and patch of the pieces of those patches that walls part.
    module.def(
        "divide_patches",
        [](const Doubles& patches, const py::array_t<std::int64_t>& patch_offsets, const Doubles& walls,
           const py::array_t<std::int64_t>& wall_offsets, const py::object& progress) {
            const FlatPolygons of = to_polygons(patches, patch_offsets, "patches");
            const FlatPolygons by = to_polygons(walls, wall_offsets, "walls");
            const Progress report = to_progress(progress);
            const DividedPatches found = without_gil([&] { return divide_patches(of, by, report); });
            const std::vector<std::int64_t> offsets(found.pieces.begin.begin(), found.pieces.begin.end());
            return py::make_tuple(to_array(found.pieces.corners), to_array(offsets), to_array(found.patch));
        },
        py::arg("patches"), py::arg("patch_offsets"), py::arg("walls"), py::arg("wall_offsets"),
        py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
