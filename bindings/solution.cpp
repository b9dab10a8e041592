#include <optional>

#include "convert.h"
#include "rooms.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/direct_at.h"
#include "surflux/solution/final_gather.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux::bindings {

namespace {

constexpr int own_rays = 256;

// Interpolates fields of a solution from values at its surfels to any places; with its scene, not across walls. Where
// `reflects` is given, objects are those of the scene, the first field is light from surfels, the second direct light,
// and places on surfaces from which none of the surfels around can be seen find them by rays of their own: from surfels
// that send what they receive, besides emission, or emission alone.
struct Field {
    Field(const Surfels& surfels, const Indices& objects, const std::vector<Doubles>& values,
          std::shared_ptr<CompiledScene> in, const py::object& progress, std::optional<bool> reflects)
        : nodes(nodes_at(surfels, to_vector(objects))), compiled(std::move(in)) {
        std::vector<std::vector<Rgb>> known;
        for (const Doubles& field : values) known.push_back(to_vec3s(field, "values"));
        const Progress report = to_progress(progress);
        without_gil([&] {
            if (compiled) {
                scene = &compiled->scene();
                tracer = &compiled->tracer();
                sight = std::make_unique<Sight>(*tracer, *scene);
                if (reflects)
                    gather = std::make_unique<FinalGather>(*scene, *tracer, *sight, nodes, light, fields, *reflects);
            }
            light.assign(nodes.size(), 0.0);
            for (const std::vector<Rgb>& field : known) {
                for (std::size_t k = 0; k < field.size(); ++k) light[k] += luminance(field[k]);
                fields.push_back(nodes.fit(field, sight.get(), report));
            }
            return 0;
        });
    }

    py::array_t<double> at(std::size_t field, const Doubles& points, const Doubles& normals,
                           const py::object& progress) const {
        require(field < fields.size(), "field: there are ", fields.size());
        const PointsAndNormals given = to_points_and_normals(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        std::vector<Rgb> out(places.size());
        const Progress report = to_progress(progress);
        without_gil([&] {
            parallel_blocks(
                places.size(), 64,
                [&](std::size_t begin, std::size_t end) {
                    std::vector<Interpolation::Weight> near;
                    for (std::size_t k = begin; k < end; ++k) {
                        const Departure from = gather ? tracer->departure(places[k], facing[k])
                                                      : Departure{places[k], facing[k], Hit::none};
                        // Else `objects` may be any numbers.
                        const std::uint32_t object =
                            from.surfel == Hit::none ? Interpolation::any_object : scene->object[from.surfel];
                        nodes.interpolation().at(places[k], facing[k], object, near);
                        if (sight && !sight->keep_joined(places[k], facing[k], nodes.sites(), light, near)) {
                            if (from.surfel != Hit::none) {
                                out[k] = found_there(field, from);
                                continue;
                            }
                            near.resize(1);  // off all surfaces: the heaviest alone
                            near[0].weight = 1.0;
                        }
                        out[k] = nodes.at(fields[field], places[k], facing[k], near);
                    }
                },
                report);
            return 0;
        });
        return to_array(out);
    }

    // Of the first field, what rays from each place find: surfels that send what they receive, besides emission.
    py::array_t<double> gathered(const Doubles& points, const Doubles& normals, int rays, std::uint64_t seed,
                                 const py::object& progress) const {
        require(gather != nullptr, "field: it has no scene to gather in");
        const PointsAndNormals given = to_points_and_normals(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        std::vector<Rgb> out(places.size());
        const Progress report = to_progress(progress);
        without_gil([&] {
            tracer->require_near(places);
            parallel_for(
                places.size(), 8,
                [&](std::size_t k) { out[k] = (*gather)(tracer->departure(places[k], facing[k]), rays, seed); },
                report);
            return 0;
        });
        return to_array(out);
    }

    // Where walls stand before all that it could be interpolated from.
    Rgb found_there(std::size_t field, const Departure& from) const {
        if (field == 0) return (*gather)(from, own_rays, 0);
        return surflux::direct_at(*scene, *tracer, {from.position}, {from.normal}, own_rays, 0)[0];
    }

    static NodalField nodes_at(const Surfels& surfels, std::vector<std::uint32_t> objects) {
        return without_gil([&] { return NodalField(surfels.positions, surfels.normals, std::move(objects)); });
    }

    NodalField nodes;
    std::shared_ptr<const CompiledScene> compiled;  // or none
    const Scene* scene = nullptr;
    const Tracer* tracer = nullptr;
    std::unique_ptr<Sight> sight;
    std::unique_ptr<FinalGather> gather;
    std::vector<NodalField::Values> fields;
    std::vector<double> light;
};

}  // namespace

void bind_solution(py::module_& module) {
    py::class_<Field>(module, "Field")
        .def(py::init<const Surfels&, const Indices&, const std::vector<Doubles>&, std::shared_ptr<CompiledScene>,
                      const py::object&, std::optional<bool>>(),
             py::arg("surfels"), py::arg("objects"), py::arg("values"), py::arg("scene"), py::arg("progress"),
             py::arg("reflects") = py::none())
        .def("at", &Field::at, py::arg("field"), py::arg("points"), py::arg("normals"), py::arg("progress"))
        .def("gathered", &Field::gathered, py::arg("points"), py::arg("normals"), py::arg("rays"), py::arg("seed"),
             py::arg("progress"));
}

}  // namespace surflux::bindings
