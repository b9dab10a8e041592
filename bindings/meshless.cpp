#include <mutex>

#include "convert.h"
#include "pictures.h"
#include "rooms.h"
#include "solution_dict.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/inside.h"
#include "surflux/meshless/meshless_solve.h"
#include "surflux/meshless/point_placement.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/render/meshless_image.h"
#include "team.h"
#include "tuning.h"

namespace surflux::bindings {

namespace {

// The last level within a region: a signed distance as a function of a position, a normal and an object, or None.
py::dict place_points(const CompiledScene& compiled, int levels, double radius, std::uint64_t seed,
                      const py::object& region, const py::object& progress) {
    SignedDistance distance;
    if (!region.is_none())
        distance = [&region](const Vec3& p, const Vec3& n, std::uint32_t object) {
            const py::gil_scoped_acquire gil;
            return region(py::make_tuple(p.x, p.y, p.z), py::make_tuple(n.x, n.y, n.z), object).cast<double>();
        };
    const Progress report = to_progress(progress);
    const PlacedPoints points = without_gil([&] {
        PointPlacement placement(compiled.scene(), compiled.tracer(), {radius, seed});
        for (int level = 0; level < levels; ++level)
            placement.add_level(level + 1 == levels ? distance : SignedDistance(), report);
        return placement.points();
    });
    py::dict out;
    out["positions"] = to_array(points.positions);
    out["normals"] = to_array(points.normals);
    out["surfels"] = to_array(points.surfels);
    out["objects"] = to_array(points.objects);
    out["level_begin"] = to_array(std::vector<std::int64_t>(points.level_begin.begin(), points.level_begin.end()));
    out["radii"] = to_array(points.first_radius);
    return out;
}

// The field of a solution anywhere on the surfaces of its scene.
class FieldOnScene {
public:
    FieldOnScene(std::shared_ptr<const MeshlessField> field, std::shared_ptr<const CompiledScene> compiled)
        : field_(std::move(field)),
          compiled_(std::move(compiled)),
          scene_(compiled_->scene()),
          tracer_(compiled_->tracer()),
          surfels_(scene_.surfels.positions) {}

    // (all that the basis holds, the part of it that is direct light, whether the place sees no function)
    py::tuple at(const Doubles& points, const Doubles& normals, const py::object& progress) const {
        const auto given = checked(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        std::vector<Rgb> all(places.size()), direct(places.size());
        std::vector<std::uint8_t> hidden(places.size(), 0);
        const Progress report = to_progress(progress);
        without_gil([&] {
            make_sight(report);
            parallel_blocks(
                places.size(), 64,
                [&](std::size_t begin, std::size_t end) {
                    std::vector<Departure> from;
                    for (std::size_t k = begin; k < end; ++k)
                        from.push_back({places[k], facing[k], tracer_.departure(places[k], facing[k]).surfel});
                    const std::vector<char> inside = inside_geometry(scene_, tracer_, from, 0);
                    for (std::size_t k = begin; k < end; ++k) {
                        if (inside[k - begin]) continue;
                        MeshlessField::At found;
                        hidden[k] = !field_->at(places[k], facing[k], object(from[k - begin]), *sight_, found);
                        all[k] = found.all;
                        direct[k] = found.direct;
                    }
                },
                report);
            return 0;
        });
        return py::make_tuple(to_array(all), to_array(direct), to_array(hidden));
    }

    // The same as `at`, of surfaces that are known, and not inside of any geometry: by surfel.
    py::tuple at_surfels(const Doubles& points, const Doubles& normals, const Indices& surfels) const {
        const auto given = checked(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        const std::vector<std::uint32_t> on = to_vector(surfels);
        std::vector<Rgb> all(places.size()), direct(places.size());
        without_gil([&] {
            parallel_for(places.size(), 256, [&](std::size_t k) {
                const MeshlessField::At found = field_->at(places[k], facing[k], scene_.object.at(on.at(k)));
                all[k] = found.all;
                direct[k] = found.direct;
            });
            return 0;
        });
        return py::make_tuple(to_array(all), to_array(direct));
    }

    // The finest level on which light was gathered, by surfel too.
    py::array_t<std::int32_t> levels_at(const Doubles& points, const Doubles& normals, const Indices& surfels) const {
        const auto given = checked(points, normals);
        const std::vector<Vec3>&places = given.points, &facing = given.normals;
        const std::vector<std::uint32_t> on = to_vector(surfels);
        std::vector<std::int32_t> out(places.size());
        without_gil([&] {
            parallel_for(places.size(), 256, [&](std::size_t k) {
                out[k] = field_->level_at(places[k], facing[k], scene_.object.at(on.at(k)));
            });
            return 0;
        });
        return to_array(out);
    }

    // As the camera sees it, by OpenGL: rows [top, top + rows) of it.
    py::dict image(const std::vector<EmitterArrays>& emitters, const CameraArrays& camera, std::size_t width,
                   std::size_t height, int samples, std::size_t top, std::size_t rows, bool culling) const {
        const std::vector<VisibleEmitter> lamps = to_emitters(emitters);
        const Camera view = to_camera(camera);
        const MeshlessImage image = without_gil([&] {
            make_sight({});
            std::call_once(drawn_once_, [&] {
                drawn_ = std::make_unique<DrawnFunctions>(*field_);
                parted_ = std::make_unique<PartedSurfels>(*field_, scene_, *sight_);
            });
            const std::lock_guard<std::mutex> lock(image_mutex_);  // of what is found out about surfels on the way
            return meshless_image(*field_, *drawn_, parted_.get(), scene_, lamps, view, width, height, samples,
                                  {top, rows}, culling);
        });
        py::dict out;
        out["all"] = to_pixels(image.all, image.height, width, 3);
        out["direct"] = to_pixels(image.direct, image.height, width, 3);
        out["depth"] = to_pixels(image.depth, image.height, width, 1);
        out["normal"] = to_pixels(image.normal, image.height, width, 3);
        out["index"] = to_pixels(image.index, image.height, width, 1);
        out["position"] = to_array(image.position).attr("reshape")(image.height, width, 3);
        out["parted"] = to_array(image.parted).attr("reshape")(image.height, width);
        out["hidden"] = to_array(image.hidden).attr("reshape")(image.height, width);
        out["fallbacks"] = image.fallbacks;
        return out;
    }

    // By function: positions, normals, radii of the supports, objects, levels, coefficients and values (of all and of
    // direct light), and whether light was gathered there; and the planes that end supports, by function. That is the
    // whole field: field_of() makes it again.
    py::dict functions() const {
        const MultilevelBasis& basis = field_->basis;
        std::vector<Vec3> positions, normals;
        std::vector<double> radii;
        std::vector<std::uint32_t> objects, levels;
        for (std::uint32_t j = 0; j < basis.size(); ++j) {
            positions.push_back(basis.position(j));
            normals.push_back(basis.normal(j));
            radii.push_back(basis.radius(j));
            objects.push_back(basis.object(j));
            levels.push_back(static_cast<std::uint32_t>(basis.level_of(j)));
        }
        py::dict out;
        out["positions"] = to_array(positions);
        out["normals"] = to_array(normals);
        out["radii"] = to_array(radii);
        out["objects"] = to_array(objects);
        out["levels"] = to_array(levels);
        out["coefficients"] = to_array(field_->coefficients);
        out["direct"] = to_array(field_->direct);
        std::vector<Rgb> values, direct_values;
        for (const MeshlessField::At& value : field_->values)
            values.push_back(value.all), direct_values.push_back(value.direct);
        out["values"] = to_array(values);
        out["direct_values"] = to_array(direct_values);
        out["gathered"] = to_array(std::vector<std::uint8_t>(field_->gathered.begin(), field_->gathered.end()));
        std::vector<std::uint32_t> cut;
        std::vector<Vec3> cut_normals;
        std::vector<double> cut_offsets;
        for (std::uint32_t j = 0; j < basis.size(); ++j)
            for (const SupportCut& c : basis.cuts(j))
                cut.push_back(j), cut_normals.push_back(c.normal), cut_offsets.push_back(c.offset);
        out["cut"] = to_array(cut);
        out["cut_normals"] = to_array(cut_normals);
        out["cut_offsets"] = to_array(cut_offsets);
        return out;
    }

private:
    void make_sight(const Progress& progress) const {
        std::call_once(sight_once_, [&] {
            auto sight = std::make_unique<BasisSight>(scene_, tracer_, field_->basis);
            sight->extend({}, progress);
            sight_ = std::move(sight);
        });
    }
    PointsAndNormals checked(const Doubles& points, const Doubles& normals) const {
        PointsAndNormals out = to_points_and_normals(points, normals);
        tracer_.require_near(out.points);
        return out;
    }
    // That of the surface there; off all surfaces, that of the nearest surfel.
    std::uint32_t object(const Departure& place) const {
        if (place.surfel != Hit::none) return scene_.object[place.surfel];
        thread_local std::vector<Neighbor> near;
        surfels_.nearest(place.position, 1, near);
        return scene_.object[near[0].index];
    }

    std::shared_ptr<const MeshlessField> field_;
    std::shared_ptr<const CompiledScene> compiled_;
    const Scene& scene_;
    const Tracer& tracer_;
    PointIndex surfels_;
    mutable std::once_flag sight_once_;
    mutable std::unique_ptr<BasisSight> sight_;
    mutable std::once_flag drawn_once_;
    mutable std::unique_ptr<DrawnFunctions> drawn_;
    mutable std::unique_ptr<PartedSurfels> parted_;
    mutable std::mutex image_mutex_;
};

constexpr std::uint32_t most_levels = 32;

// The field that functions() describes.
std::shared_ptr<const MeshlessField> field_of(const py::dict& functions) {
    const auto doubles = [&](const char* name) { return functions[name].cast<Doubles>(); };
    const auto indices = [&](const char* name) { return to_vector(functions[name].cast<Indices>()); };
    const std::vector<Vec3> positions = to_vec3s(doubles("positions"), "positions");
    const std::vector<Vec3> normals = to_vec3s(doubles("normals"), "normals");
    const std::vector<double> radii = to_vector(doubles("radii")), offsets = to_vector(doubles("cut_offsets"));
    const std::vector<std::uint32_t> objects = indices("objects"), levels = indices("levels"), cut = indices("cut");
    const std::vector<Vec3> cut_normals = to_vec3s(doubles("cut_normals"), "cut_normals");
    auto out = std::make_shared<MeshlessField>();
    out->coefficients = to_vec3s(doubles("coefficients"), "coefficients");
    out->direct = to_vec3s(doubles("direct"), "direct");
    const std::vector<Vec3> values = to_vec3s(doubles("values"), "values"),
                            direct_values = to_vec3s(doubles("direct_values"), "direct_values");
    for (const std::uint32_t one : indices("gathered")) out->gathered.push_back(static_cast<char>(one));
    const std::size_t count = positions.size();
    for (const std::size_t size :
         {normals.size(), radii.size(), objects.size(), levels.size(), out->coefficients.size(), out->direct.size(),
          out->gathered.size(), values.size(), direct_values.size()})
        require(size == count, "functions: wanted ", count, " of each array, got ", size);
    for (std::size_t j = 0; j < count; ++j) out->values.push_back({values[j], direct_values[j]});
    require(cut_normals.size() == cut.size() && offsets.size() == cut.size(),
            "functions: wanted one plane for each cut");
    without_gil([&] {
        std::size_t next = 0;
        for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
            const std::size_t level = out->basis.levels();
            require(levels[begin] >= level && levels[begin] < most_levels, "functions: wanted levels in order, got ",
                    levels[begin], " after ", level);
            while (end < count && levels[end] == level) ++end;  // none of a level that nothing was placed on
            const auto part = [&](const auto& all) {
                using List = std::decay_t<decltype(all)>;
                return List(all.begin() + static_cast<std::ptrdiff_t>(begin),
                            all.begin() + static_cast<std::ptrdiff_t>(end));
            };
            SupportOptions support;
            support.radii = part(radii);
            out->basis.add_level(part(positions), part(normals), part(objects), support);
            std::vector<SupportCut> cuts;
            for (; next < cut.size() && cut[next] < end; ++next) {
                require(cut[next] >= begin, "functions: wanted cuts by function");
                cuts.push_back({cut[next], cut_normals[next], offsets[next]});
            }
            out->basis.set_cuts(std::move(cuts));
        }
        return 0;
    });
    return out;
}

py::dict solve_scene(const std::shared_ptr<CompiledScene>& scene, int levels, double radius, double epsilon_e,
                     double epsilon_omega, int rays, int bounces, bool indirect_only, double tolerance, int probes,
                     int shadow_rays, std::uint64_t seed, const TuningValues& tuning, const py::object& progress,
                     const py::object& team) {
    MeshlessOptions options;
    options.levels = levels;
    options.radius = radius;
    options.epsilon_e = epsilon_e;
    options.epsilon_omega = epsilon_omega;
    options.rays = rays;
    options.bounces = bounces;
    options.indirect_only = indirect_only;
    options.tolerance = tolerance;
    options.direct = {probes, shadow_rays};
    options.seed = seed;
    options.tuning = tuning_with<MeshlessTuning>(tuning);
    options.team = to_team(team);
    const StageProgress report = to_stage_progress(progress);
    MeshlessSolution found = without_gil([&] { return solve_meshless(*scene, options, report); });
    py::dict out = to_dict(scene->scene(), std::move(found.solution));
    out["field"] = py::cast(without_gil([&] { return std::make_unique<FieldOnScene>(found.field, scene); }));
    out["lit"] = to_array(found.lit);
    return out;
}

}  // namespace

void bind_meshless(py::module_& module) {
    py::class_<FieldOnScene>(module, "MeshlessField")
        .def(py::init([](const py::dict& functions, const std::shared_ptr<CompiledScene>& scene) {
                 const std::shared_ptr<const MeshlessField> field = field_of(functions);
                 return without_gil([&] { return std::make_unique<FieldOnScene>(field, scene); });
             }),
             py::arg("functions"), py::arg("scene"))
        .def("at", &FieldOnScene::at, py::arg("points"), py::arg("normals"), py::arg("progress"))
        .def("at_surfels", &FieldOnScene::at_surfels, py::arg("points"), py::arg("normals"), py::arg("surfels"))
        .def("levels_at", &FieldOnScene::levels_at, py::arg("points"), py::arg("normals"), py::arg("surfels"))
        .def("image", &FieldOnScene::image, py::arg("emitters"), py::arg("camera"), py::arg("width"), py::arg("height"),
             py::arg("samples") = 1, py::arg("top") = 0, py::arg("rows") = static_cast<std::size_t>(-1),
             py::arg("culling") = true)
        .def("functions", &FieldOnScene::functions);
    module.def("solve_meshless", &solve_scene, py::arg("scene"), py::arg("levels"), py::arg("radius"),
               py::arg("epsilon_e"), py::arg("epsilon_omega"), py::arg("rays"), py::arg("bounces"),
               py::arg("indirect_only"), py::arg("tolerance"), py::arg("probes"), py::arg("shadow_rays"),
               py::arg("seed"), py::arg("tuning") = TuningValues(), py::arg("progress") = py::none(),
               py::arg("team") = py::none());
    // Constants of solve_meshless by name, as they are unless "tuning" sets them.
    module.def("meshless_tuning", &tuning_values<MeshlessTuning>);
    module.def("place_points", &place_points, py::arg("scene"), py::arg("levels"), py::arg("radius") = 0.0,
               py::arg("seed") = 0, py::arg("region") = py::none(), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
