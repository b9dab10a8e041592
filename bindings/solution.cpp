#include <cmath>
#include <string>

#include "convert.h"
#include "rooms.h"
#include "solution_dict.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/direct_at.h"
#include "surflux/solution/final_gather.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/self_check.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux::bindings {

namespace {

constexpr int own_rays = 256;

// Interpolates fields of a solution from values at its surfels to any places; with its scene, not across walls. Where
// it is said where the light of each field comes from, objects are those of the scene, and places on surfaces from
// which none of the surfels around can be seen find it by rays of their own.
struct Field {
    // Lights and Environments; what small emissive surfels emit; what surfels emit and reflect of all that fields have;
    // or that without what small ones emit.
    enum class Source { lights, small_emission, surfels, reflection };
    static Source source_named(const std::string& name) {
        if (name == "lights") return Source::lights;
        if (name == "small emission") return Source::small_emission;
        require(name == "surfels" || name == "reflection", "sources: there is no ", name);
        return name == "surfels" ? Source::surfels : Source::reflection;
    }

    Field(const Surfels& surfels, const Indices& objects, const std::vector<Doubles>& values,
          std::shared_ptr<CompiledScene> in, const py::object& progress, const std::vector<std::string>& named)
        : nodes(nodes_at(surfels, to_vector(objects))), compiled(std::move(in)) {
        require(named.empty() || named.size() == values.size(), "sources: wanted one for each field");
        for (const std::string& name : named) sources.push_back(source_named(name));
        std::vector<std::vector<Rgb>> known;
        for (const Doubles& field : values) known.push_back(to_vec3s(field, "values"));
        const Progress report = to_progress(progress);
        without_gil([&] {
            if (compiled) {
                scene = &compiled->scene();
                tracer = &compiled->tracer();
                sight = std::make_unique<Sight>(*tracer, *scene);
                if (!sources.empty())
                    gather = std::make_unique<FinalGather>(*scene, *tracer, *sight, nodes, light, fields);
            }
            light.assign(nodes.size(), Rgb{});
            for (const std::vector<Rgb>& field : known) {
                for (std::size_t k = 0; k < field.size(); ++k) light[k] += field[k];
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
        std::vector<char> lost(places.size());  // walls stand before all that they could be interpolated from
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
                                lost[k] = 1;
                                continue;
                            }
                            near.resize(1);  // off all surfaces: the heaviest alone
                            near[0].weight = 1.0;
                        }
                        out[k] = nodes.at(fields[field], places[k], facing[k], near);
                    }
                },
                report);
            find_lost(field, given, lost, standing_at(places.size(), places.size(), report), out);
            return 0;
        });
        return to_array(out);
    }

    // What rays from each place find: surfels that send what they receive, and what they emit but for small emissive
    // ones; and the share of the rays that backs end.
    py::tuple gathered(const Doubles& points, const Doubles& normals, int rays, std::uint64_t seed,
                       const py::object& progress) const {
        require(gather != nullptr, "field: it has no scene to gather in");
        const PointsAndNormals given = to_points_and_normals(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        std::vector<Rgb> out(places.size());
        std::vector<float> on_backs(places.size());
        const Progress report = to_progress(progress);
        without_gil([&] {
            tracer->require_near(places);
            const auto gather_one = [&](std::size_t k) {
                out[k] = (*gather)(tracer->departure(places[k], facing[k]), rays, seed, &on_backs[k]);
            };
            parallel_for(places.size(), 8, gather_one, report);
            return 0;
        });
        return py::make_tuple(to_array(out), to_array(on_backs));
    }

    void find_lost(std::size_t field, const PointsAndNormals& given, const std::vector<char>& lost,
                   const Progress& progress, std::vector<Rgb>& out) const {
        std::vector<std::size_t> which;
        std::vector<Vec3> at, facing;
        for (std::size_t k = 0; k < lost.size(); ++k) {
            if (!lost[k]) continue;
            which.push_back(k);
            at.push_back(given.points[k]);
            facing.push_back(given.normals[k]);
        }
        if (which.empty()) return;
        const Source source = sources[field];
        const auto gather_one = [&](std::size_t j) {
            out[which[j]] = (*gather)(tracer->departure(at[j], facing[j]), own_rays, 0);
        };
        if (source == Source::surfels || source == Source::reflection)
            parallel_for(which.size(), 8, gather_one, progress);
        if (source == Source::reflection) return;
        const auto traced = (source == Source::lights ? direct_at : emitted_at);
        const std::vector<Rgb> found = traced(*scene, *tracer, at, facing, own_rays, 0, progress);
        for (std::size_t j = 0; j < which.size(); ++j) out[which[j]] += found[j];
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
    std::vector<Source> sources;  // of fields; none where nothing is asked about it
    std::vector<NodalField::Values> fields;
    std::vector<Rgb> light;
};

// How far light is from that of the scene, with the surfaces of the surfels that have it: another reflectance than the
// scene's is theirs. `parents` are in the scene.
py::dict error_of(const CompiledScene& compiled, const Surfels& surfels, const Indices& parents,
                  const Doubles& irradiance, const Doubles& direct, std::size_t rays, std::uint64_t seed,
                  const py::object& progress) {
    const std::size_t n = surfels.size();
    Solution solution;
    solution.surfels = surfels;
    solution.parents = to_vector(parents);
    solution.irradiance = to_vec3s(irradiance, "irradiance");
    solution.direct = to_vec3s(direct, "direct");
    require(solution.parents.size() == n && solution.irradiance.size() == n && solution.direct.size() == n,
            "irradiance: wanted that of each surfel");
    require(surfels.areas.size() == n, "areas: wanted that of each surfel");
    for (const double area : surfels.areas)
        require(area > 0.0 && std::isfinite(area), "areas: wanted positive numbers");
    const Progress report = to_progress(progress);
    Figures found;
    without_gil([&] {
        Scene scene = compiled.scene();
        std::vector<Rgb> reflectance(scene.surfels.reflectance.begin(), scene.surfels.reflectance.end());
        for (std::size_t k = 0; k < n; ++k) {
            require(solution.parents[k] < reflectance.size(), "parents: wanted surfels of the scene");
            reflectance[solution.parents[k]] = surfels.reflectance[k];
        }
        scene.surfels.reflectance = reflectance;
        SelfCheckOptions options;
        options.most_rays = options.most_local_rays = rays;
        options.seed = seed;
        gathering_error(scene, compiled.tracer(), solution, options, report).note_in(found);
        return 0;
    });
    return to_dict(found);
}

}  // namespace

void bind_solution(py::module_& module) {
    py::class_<Field>(module, "Field")
        .def(py::init<const Surfels&, const Indices&, const std::vector<Doubles>&, std::shared_ptr<CompiledScene>,
                      const py::object&, const std::vector<std::string>&>(),
             py::arg("surfels"), py::arg("objects"), py::arg("values"), py::arg("scene"), py::arg("progress"),
             py::arg("sources") = std::vector<std::string>())
        .def("at", &Field::at, py::arg("field"), py::arg("points"), py::arg("normals"), py::arg("progress"))
        .def("gathered", &Field::gathered, py::arg("points"), py::arg("normals"), py::arg("rays"), py::arg("seed"),
             py::arg("progress"));
    module.def("error_of", &error_of, py::arg("scene"), py::arg("surfels"), py::arg("parents"), py::arg("irradiance"),
               py::arg("direct"), py::arg("rays"), py::arg("seed"), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
