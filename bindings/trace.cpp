#include "convert.h"
#include "rooms.h"
#include "surflux/core/parallel.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/trace/facing.h"
#include "surflux/trace/inward.h"

namespace surflux::bindings {

namespace {

// Closest hit of each ray from a surfel, or from the air (Hit::none): surfel or -1, whether on its front, the distance.
py::tuple closest_hits(const CompiledScene& scene, const Indices& surfels, const Doubles& points,
                       const Doubles& directions) {
    const std::vector<std::uint32_t> from = to_vector(surfels);
    const std::vector<Vec3> at = to_vec3s(points, "points"), along = to_vec3s(directions, "directions");
    require(at.size() == from.size() && along.size() == from.size(), "points: wanted as many as surfels");
    for (std::uint32_t i : from)
        require(i == Hit::none || i < scene.scene().surfels.size(), "surfels: there is none of index ", i);
    std::vector<std::int64_t> met(from.size());
    std::vector<char> front(from.size());
    std::vector<double> distance(from.size());
    without_gil([&] {
        const Tracer& tracer = scene.tracer();
        parallel_for(from.size(), 1024, [&](std::size_t k) {
            const bool in_air = from[k] == Hit::none;
            const Departure start = in_air ? Departure{at[k], along[k], Hit::none} : tracer.on(from[k], at[k]);
            const Hit hit = tracer.closest({start, along[k]});
            met[k] = hit ? std::int64_t{hit.surfel} : -1;
            front[k] = hit.front;
            distance[k] = hit.distance;
        });
    });
    return py::make_tuple(to_array(met), to_array(front), to_array(distance));
}

// Closest front hit of rays from points in the air, with back faces culled: surfel or -1, and the distance.
py::tuple seen_fronts(const CompiledScene& scene, const Doubles& points, const Doubles& directions) {
    const std::vector<Vec3> at = to_vec3s(points, "points"), along = to_vec3s(directions, "directions");
    require(at.size() == along.size(), "directions: wanted as many as points");
    std::vector<std::int64_t> met(at.size(), -1);
    std::vector<double> distance(at.size(), 0.0);
    without_gil([&] {
        const Tracer& tracer = scene.tracer();
        parallel_blocks(at.size(), 1024, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<std::size_t> of;
            for (std::size_t k = begin; k < end; ++k) {
                rays.push_back({{at[k], along[k], Hit::none}, along[k]});
                of.push_back(k);
            }
            std::vector<Hit> hits;
            while (!rays.empty()) {
                tracer.closest(rays, hits);
                std::size_t left = 0;
                for (std::size_t r = 0; r < rays.size(); ++r) {
                    const std::size_t k = of[r];
                    if (!hits[r]) continue;
                    distance[k] += hits[r].distance;
                    if (dot(scene.scene().surfels.normals[hits[r].surfel], along[k]) < 0.0) {
                        met[k] = hits[r].surfel;
                        continue;
                    }
                    distance[k] += tracer.contact(hits[r].surfel);
                    rays[left] = {{at[k] + distance[k] * along[k], along[k], Hit::none}, along[k]};
                    of[left++] = k;
                }
                rays.resize(left);
                of.resize(left);
            }
        });
    });
    return py::make_tuple(to_array(met), to_array(distance));
}

// Sheet of each point or -1, whether it is turned, or unsure, and of each sheet its kind, whether it is backwards, or
// settled, the shares of surfels against that and of tangled links, and the margins of light and of bodies.
py::dict facing(const Doubles& at, const Doubles& along, const Doubles& witnesses, std::size_t smallest, int rays,
                std::size_t most, std::uint64_t seed, bool estimated, const py::object& progress) {
    const std::vector<Vec3> points = to_vec3s(at, "points"), normals = to_vec3s(along, "normals");
    require(points.size() == normals.size(), "normals: wanted as many as points");
    FacingOptions options;
    options.sheets = {smallest, rays, seed, to_vec3s(witnesses, "witnesses"), estimated};
    options.most = most;
    const Progress report = to_progress(progress);
    const Facing found = without_gil([&] { return facing_of(points, normals, options, report); });
    std::vector<std::int64_t> sheet(found.sheet.size());
    for (std::size_t i = 0; i < sheet.size(); ++i)
        sheet[i] = found.sheet[i] == SheetSides::none ? -1 : std::int64_t{found.sheet[i]};
    std::vector<char> kind, backwards, settled;
    std::vector<double> against, margin, tangled, bodies;
    for (const OrientedSheet& s : found.sheets) {
        kind.push_back(static_cast<char>(s.kind));
        backwards.push_back(s.backwards);
        settled.push_back(s.settled);
        against.push_back(s.against);
        margin.push_back(s.margin);
        tangled.push_back(s.tangled);
        bodies.push_back(s.bodies);
    }
    py::dict out;
    out["sheet"] = to_array(sheet);
    out["turned"] = to_array(found.turned);
    out["unsure"] = to_array(found.unsure);
    out["kind"] = to_array(kind);
    out["backwards"] = to_array(backwards);
    out["settled"] = to_array(settled);
    out["against"] = to_array(against);
    out["tangled"] = to_array(tangled);
    out["margin"] = to_array(margin);
    out["bodies"] = to_array(bodies);
    return out;
}

}  // namespace

void bind_trace(py::module_& module) {
    module.def("closest_hits", &closest_hits, py::arg("scene"), py::arg("surfels"), py::arg("points"),
               py::arg("directions"));
    module.def("seen_fronts", &seen_fronts, py::arg("scene"), py::arg("points"), py::arg("directions"));
    module.def("facing", &facing, py::arg("points"), py::arg("normals"), py::arg("witnesses"), py::arg("smallest"),
               py::arg("rays"), py::arg("most"), py::arg("seed"), py::arg("estimated"),
               py::arg("progress") = py::none());
    module.def(
        "inward_patches",
        [](const Surfels& surfels, std::size_t smallest, int rays, std::uint64_t seed, bool rooms,
           const py::object& progress) {
            const InwardOptions options{smallest, rays, seed, rooms};
            const Progress report = to_progress(progress);
            const Inward found = without_gil([&] { return inward_patches(surfels, options, report); });
            return py::make_tuple(to_array(found.patch), to_array(found.unsure));
        },
        py::arg("surfels"), py::arg("smallest"), py::arg("rays"), py::arg("seed"), py::arg("rooms"),
        py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
