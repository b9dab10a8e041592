#include <numeric>
#include <optional>

#include "convert.h"
#include "rooms.h"

#include "surflux/core/parallel.h"
#include "surflux/lights/direct_at.h"
#include "surflux/lights/free_directions.h"
#include "surflux/lights/hemisphere_row.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/patch_rays.h"
#include "surflux/lights/sky_patches.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/trace/onto_surface.h"

namespace surflux::bindings {

namespace {

using Bytes = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

// The bytes of as many rows as there are normals.
const std::uint8_t* to_rows(const Bytes& bits, std::size_t rows, std::size_t directions) {
    require(bits.ndim() == 2 && static_cast<std::size_t>(bits.shape(0)) == rows &&
                static_cast<std::size_t>(bits.shape(1)) == FreeDirections::row_bytes(directions),
            "bits: wanted a row of bytes for each normal, a bit for each direction");
    return bits.data();
}

// Of some surfels, or of all where they are None.
py::array free_directions(const CompiledScene& scene, const Doubles& directions, const py::object& progress,
                          const std::optional<Indices>& surfels) {
    const std::vector<Vec3> along = to_vec3s(directions, "directions");
    std::vector<std::uint32_t> which;
    if (surfels) {
        which = to_vector(*surfels);
        for (const std::uint32_t i : which)
            require(i < scene.scene().surfels.size(), "surfels: there is none of index ", i);
    } else {
        which.resize(scene.scene().surfels.size());
        std::iota(which.begin(), which.end(), 0u);
    }
    const Progress report = to_progress(progress);
    FreeDirections found = without_gil(
        [&] { return find_free_directions(scene.scene().surfels, which, scene.tracer(report), along, report); });
    return handed_over(std::move(found.bits))
        .reshape({static_cast<py::ssize_t>(which.size()),
                  static_cast<py::ssize_t>(FreeDirections::row_bytes(along.size()))});
}

py::tuple direction_sums(const Doubles& normals, const Bytes& bits, const Doubles& vectors, bool cosine) {
    const std::vector<Vec3> facing = to_vec3s(normals, "normals"), light = to_vec3s(vectors, "vectors");
    const std::uint8_t* rows = to_rows(bits, facing.size(), light.size());
    const DirectionSums sums = without_gil([&] { return sum_directions(facing, rows, light, cosine); });
    return py::make_tuple(to_array(sums.arrived), to_array(sums.unoccluded));
}

// (m, 3): irradiance that direct_at or emitted_at traces anew from places on surfaces.
template <auto irradiance_at>
py::array traced(const CompiledScene& scene, const Doubles& points, const Doubles& normals, int rays,
                 std::uint64_t seed, const py::object& progress) {
    const PointsAndNormals at = to_points_and_normals(points, normals);
    const Progress report = to_progress(progress);
    return to_array(without_gil(
        [&] { return irradiance_at(scene.scene(), scene.tracer(report), at.points, at.normals, rays, seed, report); }));
}

// (m, 3): points of surfaces, those that lie behind theirs moved up to it.
py::array onto_surface_of(const CompiledScene& scene, const Doubles& points, const Doubles& normals) {
    const PointsAndNormals at = to_points_and_normals(points, normals);
    return to_array(
        without_gil([&] { return onto_surface(scene.scene().surfels, scene.tracer(), at.points, at.normals); }));
}

// Cosine-distributed rays from places, where they end on the fronts of surfels that reflect: the positions (k, 3), the
// surfels and the places (k,) by number; and of each place what its rays see of emission that is not sampled as a
// light (m, 3), and the share of them that backs end (m,).
py::tuple ray_ends(const CompiledScene& compiled, const Doubles& points, const Doubles& normals, int rays,
                   std::uint64_t seed, const py::object& progress) {
    const PointsAndNormals at = to_points_and_normals(points, normals);
    const std::vector<Vec3>&places = at.points, &facing = at.normals;
    const Progress report = to_progress(progress);
    std::vector<std::vector<Vec3>> ends(places.size());
    std::vector<std::vector<std::uint32_t>> on(places.size());
    std::vector<Rgb> emitted(places.size());
    std::vector<float> on_backs(places.size());
    without_gil([&] {
        const Surfels& s = compiled.scene().surfels;
        const Tracer& tracer = compiled.tracer(report);
        tracer.require_near(places);
        const LightSampler emitters = LightSampler::of_surfels(compiled.scene());
        const SurfelPoints shapes(s);
        const auto shoot = [&](std::size_t k) {
            const Departure from = tracer.departure(places[k], facing[k]);
            HemisphereRow row;
            gather_row(shapes, tracer, {from.position, from.normal, from.surfel, Place::point}, rays, seed, row);
            for (std::size_t r = 0; r < row.rays.size(); ++r) {
                const Hit& hit = row.hits[r];
                if (hit && !hit.front) on_backs[k] += 1.0f / static_cast<float>(rays);
                if (!hit.front) continue;
                if (!emitters.samples(hit.surfel)) emitted[k] += s.emission[hit.surfel] / rays;
                if (s.reflectance[hit.surfel] == Rgb{}) continue;
                ends[k].push_back(row.rays[r].from.position + hit.distance * row.rays[r].direction);
                on[k].push_back(hit.surfel);
            }
        };
        parallel_for(places.size(), 8, shoot, report);
        return 0;
    });
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> surfels, of;
    for (std::size_t k = 0; k < places.size(); ++k) {
        positions.insert(positions.end(), ends[k].begin(), ends[k].end());
        surfels.insert(surfels.end(), on[k].begin(), on[k].end());
        of.insert(of.end(), on[k].size(), static_cast<std::uint32_t>(k));
    }
    return py::make_tuple(to_array(positions), to_array(surfels), to_array(of), to_array(emitted), to_array(on_backs));
}

}  // namespace

void bind_lights(py::module_& module) {
    py::class_<SkyPatches>(module, "SkyPatches")
        .def(py::init<int>(), py::arg("subdivision"))
        .def("__len__", &SkyPatches::size)
        .def_property_readonly("directions", [](const SkyPatches& p) { return to_array(p.directions()); })
        .def_property_readonly("solid_angles", [](const SkyPatches& p) { return to_array(p.solid_angles()); })
        .def("index",
             [](const SkyPatches& p, const Doubles& directions) {
                 std::vector<std::uint32_t> out;
                 for (const Vec3& d : to_vec3s(directions, "directions"))
                     out.push_back(static_cast<std::uint32_t>(p.index_of(d)));
                 return to_array(out);
             })
        .def("radiance", [](const SkyPatches& p, const Environment& environment) {
            return to_array(without_gil([&] { return patch_radiances(environment, p); }));
        });
    py::class_<PatchRays>(module, "PatchRays")
        .def(py::init<const SkyPatches&, std::size_t, std::uint64_t>(), py::arg("patches"), py::arg("of_patch"),
             py::arg("seed"))
        .def_property_readonly("directions", [](const PatchRays& p) { return to_array(p.directions()); })
        .def(
            "coefficients",
            [](const PatchRays& p, const Doubles& normals, const Bytes& bits) {
                const std::vector<Vec3> facing = to_vec3s(normals, "normals");
                const std::uint8_t* rows = to_rows(bits, facing.size(), p.directions().size());
                const auto n = static_cast<py::ssize_t>(facing.size());
                return handed_over(without_gil([&] { return p.coefficients(facing, rows); }))
                    .reshape({n, static_cast<py::ssize_t>(p.patches())});
            },
            py::arg("normals"), py::arg("bits"));
    module.def("free_directions", &free_directions, py::arg("scene"), py::arg("directions"),
               py::arg("progress") = py::none(), py::arg("surfels") = py::none());
    module.def("direct_at", &traced<direct_at>, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("rays"), py::arg("seed"), py::arg("progress"));
    module.def("ray_ends", &ray_ends, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("rays"),
               py::arg("seed"), py::arg("progress"));
    module.def("emitted_at", &traced<emitted_at>, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("rays"), py::arg("seed"), py::arg("progress"));
    // Whether all emissive surfels that are sampled as lights are patches: of disks, which overlap, rays tell less than
    // values between surfels.
    module.def(
        "samples_patches_alone",
        [](const CompiledScene& scene) {
            const Surfels& s = scene.scene().surfels;
            const LightSampler emitters = LightSampler::of_surfels(scene.scene());
            const std::vector<std::uint32_t> begin = triangle_ranges(s);
            for (std::uint32_t i = 0; i < s.size(); ++i)
                if (emitters.samples(i) && begin[i] == begin[i + 1]) return false;
            return true;
        },
        py::arg("scene"));
    module.def("onto_surface", &onto_surface_of, py::arg("scene"), py::arg("points"), py::arg("normals"));
    module.def("direction_sums", &direction_sums, py::arg("normals"), py::arg("bits"), py::arg("vectors"),
               py::arg("cosine"));
}

}  // namespace surflux::bindings
