#include "convert.h"
#include "rooms.h"
#include "solution_dict.h"
#include "surflux/transfer/local_transfer.h"

namespace surflux::bindings {

namespace {

std::unique_ptr<LocalTransfer> make_local(const std::shared_ptr<CompiledScene>& scene, int levels, double radius,
                                          double epsilon, int rays, std::size_t senders, std::size_t samples,
                                          std::uint64_t seed, const py::object& progress) {
    OperatorOptions options;
    options.levels = levels;
    options.radius = radius;
    options.epsilon = epsilon;
    options.rays = rays;
    options.senders = senders;
    options.samples = samples;
    options.seed = seed;
    const StageProgress report = to_stage_progress(progress);
    return without_gil([&] {
        Figures timings;
        TransportOperator transport = build_operator(*scene, options, report, timings);
        return std::make_unique<LocalTransfer>(scene, std::move(transport), std::move(timings));
    });
}

}  // namespace

void bind_transfer(py::module_& module) {
    py::class_<LocalTransfer>(module, "LocalTransfer")
        .def(py::init(&make_local), py::arg("scene"), py::arg("levels"), py::arg("radius"), py::arg("epsilon"),
             py::arg("rays"), py::arg("senders"), py::arg("samples"), py::arg("seed"), py::arg("progress") = py::none())
        .def(
            "indirect",
            [](const LocalTransfer& transfer, const std::vector<Light>& lights, const py::object& reflectance,
               int bounces, std::size_t shadow_rays, std::uint64_t seed) {
                const std::vector<Rgb> own =
                    reflectance.is_none() ? std::vector<Rgb>() : to_vec3s(reflectance.cast<Doubles>(), "reflectance");
                return handed_over(
                    without_gil([&] { return transfer.indirect(lights, own, {bounces, shadow_rays, seed}); }));
            },
            py::arg("lights"), py::arg("reflectance"), py::arg("bounces"), py::arg("shadow_rays"), py::arg("seed"))
        .def(
            "direct",
            [](const LocalTransfer& transfer, const std::vector<Light>& lights, int probes, int shadow_rays,
               std::uint64_t seed, const py::object& progress) {
                const Progress report = to_progress(progress);
                return handed_over(
                    without_gil([&] { return transfer.direct(lights, {probes, shadow_rays}, seed, report); }));
            },
            py::arg("lights"), py::arg("probes"), py::arg("shadow_rays"), py::arg("seed"),
            py::arg("progress") = py::none())
        .def_property_readonly("timings", [](const LocalTransfer& t) { return to_dict(t.timings()); })
        .def_property_readonly("receivers",
                               [](const LocalTransfer& t) {
                                   return py::make_tuple(to_array(t.transport().positions),
                                                         to_array(t.transport().normals));
                               })
        .def_property_readonly("bytes", [](const LocalTransfer& t) { return t.transport().bytes(); })
        .def_property_readonly("rays", [](const LocalTransfer& t) { return t.transport().rays; })
        .def_property_readonly("links", [](const LocalTransfer& t) { return t.transport().links.size(); })
        .def_property_readonly("areas", [](const LocalTransfer& t) { return to_array(t.transport().areas); })
        .def_property_readonly("sizes", [](const LocalTransfer& t) {
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

}  // namespace surflux::bindings
