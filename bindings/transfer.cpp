#include "arrays.h"
#include "rooms.h"
#include "solution_dict.h"
#include "surflux/solution/stopwatch.h"
#include "surflux/transfer/distant_transfer.h"
#include "surflux/transfer/local_transfer.h"
#include "surflux/transfer/operator_arrays.h"
#include "surflux/transfer/sky_transfer.h"
#include "team.h"

namespace surflux::bindings {

namespace {

using Compiled = std::shared_ptr<CompiledScene>;

constexpr std::uint64_t visibility_stream = 0x5f70, patch_stream = 0x6a91;

std::unique_ptr<LocalTransfer> make_local(const Compiled& scene, const OperatorOptions& options,
                                          const py::object& progress) {
    const StageProgress report = to_stage_progress(progress);
    return without_gil([&] {
        Figures timings;
        TransportOperator transport = build_operator(*scene, options, report, timings);
        return std::make_unique<LocalTransfer>(scene, std::move(transport), std::move(timings));
    });
}

std::unique_ptr<DistantTransfer> make_distant(const Compiled& scene, OperatorOptions options, int visibility_rays,
                                              const py::object& progress) {
    options.lighting = OperatorOptions::Lighting::distant;
    const StageProgress report = to_stage_progress(progress);
    return without_gil([&] {
        Figures timings;
        TransportOperator transport = build_operator(*scene, options, report, timings);
        Stopwatch watch(timings);
        DistantTransfer::Visibility visibility =
            find_visibility(transport, SurfelPoints(scene->scene().surfels), scene->tracer(), visibility_rays,
                            options.seed + visibility_stream, report ? report("visibility") : Progress{}, options.team);
        watch.lap("visibility");
        return std::make_unique<DistantTransfer>(scene, std::move(transport), std::move(visibility),
                                                 std::move(timings));
    });
}

std::unique_ptr<SkyTransfer> make_sky(const Compiled& scene, OperatorOptions options, const SkyPatches& patches,
                                      const py::object& progress) {
    options.lighting = OperatorOptions::Lighting::sky;
    const StageProgress report = to_stage_progress(progress);
    return without_gil([&] {
        Figures timings;
        TransportOperator transport = build_operator(*scene, options, report, timings);
        Stopwatch watch(timings);
        SkyIrradiance direct(transport, SurfelPoints(scene->scene().surfels), scene->tracer(), patches,
                             options.seed + patch_stream, report ? report("sky") : Progress{}, options.team);
        watch.lap("sky");
        return std::make_unique<SkyTransfer>(scene, std::move(transport), patches, std::move(direct),
                                             std::move(timings));
    });
}

// What an operator is made of, and under "counts" the samples of each group, levels for
// reflections, rays and what was left out.
py::dict operator_arrays(const TransportOperator& of, const py::object& owner) {
    py::dict out;
    for_arrays(of, [&](const char* name, const auto& values) { out[name] = view_of(values, owner); });
    out["counts"] = to_array(std::vector<std::uint64_t>{of.samples.of_leaf, of.bounce_levels, of.rays, of.left_out});
    return out;
}

TransportOperator take_operator(const py::dict& arrays, const CompiledScene& scene) {
    TransportOperator out;
    for_arrays(out, [&](const char* name, auto& values) { take(arrays, name, values); });
    std::vector<std::uint64_t> counts;
    take(arrays, "counts", counts);
    require(counts.size() == 4, "counts: wanted 4");
    out.samples.of_leaf = counts[0];
    out.bounce_levels = counts[1];
    out.rays = counts[2];
    out.left_out = counts[3];
    without_gil([&] { require_whole(out, scene.scene().surfels.size()); });
    return out;
}

std::unique_ptr<LocalTransfer> local_of_arrays(const Compiled& scene, const py::dict& arrays, const Figures& timings) {
    TransportOperator transport = take_operator(arrays, *scene);
    require(transport.samples.of_leaf > 0, "samples: wanted at least 1 for each leaf");
    return without_gil([&] { return std::make_unique<LocalTransfer>(scene, std::move(transport), timings); });
}

py::dict distant_arrays(const py::object& self) {
    const auto& of = self.cast<const DistantTransfer&>();
    py::dict out = operator_arrays(of.transport(), self);
    out["visibility"] = view_of(of.visibility().values, self);
    out["visibility_scale"] = view_of(of.visibility().scale, self);
    return out;
}

std::unique_ptr<DistantTransfer> distant_of_arrays(const Compiled& scene, const py::dict& arrays,
                                                   const Figures& timings) {
    TransportOperator transport = take_operator(arrays, *scene);
    DistantTransfer::Visibility visibility;
    take(arrays, "visibility", visibility.values);
    take(arrays, "visibility_scale", visibility.scale);
    return without_gil(
        [&] { return std::make_unique<DistantTransfer>(scene, std::move(transport), std::move(visibility), timings); });
}

py::dict sky_arrays(const py::object& self) {
    const auto& of = self.cast<const SkyTransfer&>();
    py::dict out = operator_arrays(of.transport(), self);
    out["sky_begin"] = view_of(of.direct().begin, self);
    out["sky"] = view_of(of.direct().entries, self);
    out["sky_scale"] = view_of(of.direct().scale, self);
    out["patches"] = to_array(std::vector<std::uint32_t>{static_cast<std::uint32_t>(of.patches().size())});
    return out;
}

std::unique_ptr<SkyTransfer> sky_of_arrays(const Compiled& scene, const py::dict& arrays, const Figures& timings) {
    TransportOperator transport = take_operator(arrays, *scene);
    SkyIrradiance direct;
    take(arrays, "sky_begin", direct.begin);
    take(arrays, "sky", direct.entries);
    take(arrays, "sky_scale", direct.scale);
    std::vector<std::uint32_t> count;
    take(arrays, "patches", count);
    int subdivision = 1;
    while (subdivision < 8 && SkyPatches(subdivision).size() < (count.empty() ? 0 : count[0])) ++subdivision;
    SkyPatches patches(subdivision);
    require(count.size() == 1 && count[0] == patches.size(), "patches: wanted a number of them");
    return without_gil([&] {
        return std::make_unique<SkyTransfer>(scene, std::move(transport), std::move(patches), std::move(direct),
                                             timings);
    });
}

std::vector<Rgb> to_reflectance(const py::object& reflectance) {
    return reflectance.is_none() ? std::vector<Rgb>() : to_vec3s(reflectance.cast<Doubles>(), "reflectance");
}

// What lights bring to all surfels directly.
template <class Transfer>
using DirectLight = std::vector<Rgb> (Transfer::*)(const std::vector<Light>&, const DirectOptions&, std::uint64_t,
                                                   const Progress&) const;
template <class Transfer>
void bind_direct(py::class_<Transfer>& to, const char* name, DirectLight<Transfer> direct) {
    to.def(
        name,
        [direct](const Transfer& transfer, const std::vector<Light>& lights, int probes, int shadow_rays,
                 std::uint64_t seed, const py::object& progress) {
            const Progress report = to_progress(progress);
            return handed_over(
                without_gil([&] { return (transfer.*direct)(lights, {probes, shadow_rays}, seed, report); }));
        },
        py::arg("lights"), py::arg("probes"), py::arg("shadow_rays"), py::arg("seed"),
        py::arg("progress") = py::none());
}

// What all kinds of transfer tell of their operator.
template <class Transfer>
void bind_operator(py::class_<Transfer>& to) {
    to.def_property_readonly("timings", [](const Transfer& t) { return to_dict(t.timings()); })
        .def_property_readonly("receivers",
                               [](const Transfer& t) {
                                   return py::make_tuple(to_array(t.transport().positions),
                                                         to_array(t.transport().normals));
                               })
        .def_property_readonly("bytes", [](const Transfer& t) { return t.bytes(); })
        .def_property_readonly("rays", [](const Transfer& t) { return t.transport().rays; })
        .def_property_readonly("left_out", [](const Transfer& t) { return t.transport().left_out; })
        .def("emitted",
             [](const Transfer& t) -> py::object {
                 if (!t.emitted().any_sampled()) return py::none();
                 return to_array(without_gil([&] { return t.emitted().at_surfels(); }));
             })
        .def_property_readonly("links", [](const Transfer& t) { return t.transport().links.size(); })
        .def_property_readonly("areas", [](const Transfer& t) { return to_array(t.transport().areas); })
        .def("losses",
             [](const Transfer& t) {
                 const std::vector<float> found = without_gil([&] { return t.transport().losses(); });
                 py::array_t<float> out({found.size() / 2, std::size_t{2}});
                 std::copy(found.begin(), found.end(), out.mutable_data());
                 return out;
             })
        .def_property_readonly("sizes", [](const Transfer& t) {
            const TransportOperator& of = t.transport();
            py::dict out;
            out["receivers"] = of.rows.size();
            out["functions"] = of.receiver_of.size();
            out["groups"] = of.senders.leaves.size();
            out["at_groups"] = of.at_groups.entries.size();
            out["at_surfels"] = of.at_surfels.entries.size();
            return out;
        });
}

}  // namespace

void bind_transfer(py::module_& module) {
    PYBIND11_NUMPY_DTYPE(TransportOperator::Row, begin, end, per_ray, u, v, escape, into_backs);
    PYBIND11_NUMPY_DTYPE(TransportOperator::Slope, u, v);
    PYBIND11_NUMPY_DTYPE(SenderSamples::Sample, x, y, z, normal_x, normal_y, normal_z, surfel);
    PYBIND11_NUMPY_DTYPE(SparseRows::Entry, column, weight);
    PYBIND11_NUMPY_DTYPE(SenderGroups::Node, parent, child, area, radius, alike, weight);
    PYBIND11_NUMPY_DTYPE(SkyIrradiance::Entry, patch, share);
    py::class_<OperatorOptions>(module, "OperatorOptions")
        .def(py::init([](int levels, double radius, double epsilon, int rays, std::size_t senders, std::size_t samples,
                         const py::object& region, double max_memory, std::uint64_t seed, const py::object& team) {
                 OperatorOptions options;
                 options.levels = levels;
                 options.radius = radius;
                 options.epsilon = epsilon;
                 options.rays = rays;
                 options.senders = senders;
                 options.samples = samples;
                 if (!region.is_none()) {
                     const std::vector<Vec3> corners = to_vec3s(region.cast<Doubles>(), "region");
                     require(corners.size() == 2, "region: wanted 2 corners");
                     options.region = Box{corners[0], corners[1]};
                 }
                 options.max_memory = max_memory;
                 options.seed = seed;
                 options.team = to_team(team);
                 return options;
             }),
             py::kw_only(), py::arg("levels"), py::arg("radius"), py::arg("epsilon"), py::arg("rays"),
             py::arg("senders"), py::arg("samples"), py::arg("region"), py::arg("max_memory"), py::arg("seed"),
             py::arg("team") = py::none());
    py::class_<LocalTransfer> local(module, "LocalTransfer");
    local.def(py::init(&make_local), py::arg("scene"), py::arg("options"), py::arg("progress") = py::none())
        .def(
            "indirect",
            [](const LocalTransfer& transfer, const std::vector<Light>& lights, const py::object& reflectance,
               int bounces, std::size_t shadow_rays, std::uint64_t seed) {
                const std::vector<Rgb> own = to_reflectance(reflectance);
                return handed_over(
                    without_gil([&] { return transfer.indirect(lights, own, {bounces, shadow_rays, seed}); }));
            },
            py::arg("lights"), py::arg("reflectance"), py::arg("bounces"), py::arg("shadow_rays"), py::arg("seed"));
    bind_direct(local, "direct", &LocalTransfer::direct);
    local.def_static("of_arrays", &local_of_arrays, py::arg("scene"), py::arg("arrays"), py::arg("timings"))
        .def("arrays", [](const py::object& self) {
            return operator_arrays(self.cast<const LocalTransfer&>().transport(), self);
        });
    bind_operator(local);
    py::class_<IncidentLight>(module, "IncidentLight")
        .def("irradiance",
             [](const IncidentLight& light) {
                 IncidentLight::Irradiance found = without_gil([&] { return light.irradiance(); });
                 return py::make_tuple(handed_over(std::move(found.distant)), handed_over(std::move(found.all)));
             })
        .def(
            "mirrored",
            [](const IncidentLight& light, const Doubles& directions, const Doubles& exponents) {
                const std::vector<Vec3> to = to_vec3s(directions, "directions");
                const std::vector<double> by = to_vector(exponents);
                return handed_over(without_gil([&] { return light.mirrored(to, by); }));
            },
            py::arg("directions"), py::arg("exponents"));
    py::class_<DistantTransfer> distant(module, "DistantTransfer");
    distant
        .def(py::init(&make_distant), py::arg("scene"), py::arg("options"), py::arg("visibility_rays"),
             py::arg("progress") = py::none())
        .def(
            "incident",
            [](const DistantTransfer& transfer, const Doubles& environment, const py::object& reflectance,
               int bounces) {
                const std::vector<Rgb> coefficients = to_vec3s(environment, "environment");
                require(coefficients.size() == SphericalHarmonics::count(DistantTransfer::source_order),
                        "environment: wanted ", SphericalHarmonics::count(DistantTransfer::source_order),
                        " coefficients, got ", coefficients.size());
                const std::vector<Rgb> own = to_reflectance(reflectance);
                return without_gil([&] { return transfer.incident(coefficients, own, bounces); });
            },
            py::arg("environment"), py::arg("reflectance"), py::arg("bounces"));
    distant.def_static("of_arrays", &distant_of_arrays, py::arg("scene"), py::arg("arrays"), py::arg("timings"))
        .def("arrays", &distant_arrays);
    bind_operator(distant);
    py::class_<SkyTransfer> sky(module, "SkyTransfer");
    sky.def_property_readonly("patches", &SkyTransfer::patches)
        .def(py::init(&make_sky), py::arg("scene"), py::arg("options"), py::arg("patches"),
             py::arg("progress") = py::none())
        .def(
            "irradiance",
            [](const SkyTransfer& transfer, const Doubles& radiances, const py::object& sun,
               const py::object& reflectance, int bounces) {
                const std::vector<Rgb> of_patches = to_vec3s(radiances, "radiances");
                require(of_patches.size() == transfer.patches().size(), "radiances: wanted one for each patch");
                const std::vector<Rgb> own = to_reflectance(reflectance);
                const std::vector<Rgb> of_sun =
                    sun.is_none() ? std::vector<Rgb>() : to_vec3s(sun.cast<Doubles>(), "sun");
                SkyTransfer::Irradiance found =
                    without_gil([&] { return transfer.irradiance(of_patches, of_sun, own, bounces); });
                return py::make_tuple(handed_over(std::move(found.direct)), handed_over(std::move(found.all)));
            },
            py::arg("radiances"), py::arg("sun"), py::arg("reflectance"), py::arg("bounces"))
        .def(
            "coefficients",
            [](const SkyTransfer& transfer, const Indices& surfels, int bounces, const py::object& progress) {
                const std::vector<std::uint32_t> of = to_vector(surfels);
                const Progress report = to_progress(progress);
                const std::vector<float> found =
                    without_gil([&] { return transfer.coefficients(of, bounces, report); });
                py::array_t<float> out({of.size(), transfer.patches().size(), std::size_t{3}});
                std::copy(found.begin(), found.end(), out.mutable_data());
                return out;
            },
            py::arg("surfels"), py::arg("bounces"), py::arg("progress") = py::none());
    sky.def_static("of_arrays", &sky_of_arrays, py::arg("scene"), py::arg("arrays"), py::arg("timings"))
        .def("arrays", &sky_arrays);
    bind_direct(sky, "sunlight", &SkyTransfer::sunlight);
    bind_operator(sky);
}

}  // namespace surflux::bindings
