#include <cmath>
#include <map>

#include "convert.h"
#include "rooms.h"
#include "solution_dict.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/form_factor_operator.h"
#include "surflux/radiosity/form_factors.h"
#include "surflux/radiosity/hierarchy.h"
#include "surflux/radiosity/solve.h"
#include "team.h"
#include "tuning.h"

namespace surflux::bindings {

namespace {

py::dict solve_scene(const CompiledScene& scene, const std::string& transport, double zeta, bool insert,
                     std::size_t max_surfels, double tolerance, int rays, int probes, int shadow_rays, double epsilon,
                     double max_memory, std::uint64_t seed, const TuningValues& tuning, const py::object& progress,
                     const py::object& team) {
    SolveOptions options;
    options.transport = transport == "pairs"  ? Transport::pairs
                        : transport == "rays" ? Transport::rays
                                              : Transport::automatic;
    options.zeta = zeta;
    options.insert = insert;
    options.max_surfels = max_surfels;
    options.tolerance = tolerance;
    options.rays = rays;
    options.direct = {probes, shadow_rays};
    options.exchange.epsilon = epsilon;
    options.exchange.max_memory = max_memory;
    options.seed = seed;
    if (options.transport == Transport::pairs)
        options.exchange.tuning = tuning_with<PairsTuning>(tuning);
    else
        options.tuning = tuning_with<RefinementTuning>(tuning);
    options.team = to_team(team);
    const StageProgress report = to_stage_progress(progress);
    Solution solution = without_gil([&] { return solve(scene, options, report); });
    return to_dict(scene.scene(), std::move(solution));
}

// F, 1 less its row sums (empty without visibility), how many pairs did not come to the error, and the rays.
py::tuple form_factors_of_scene(const CompiledScene& scene, bool visibility, double error, int rays, double epsilon,
                                std::uint64_t seed, const TuningValues& tuning, const py::object& progress) {
    const StageProgress stages = to_stage_progress(progress);
    const auto side = static_cast<py::ssize_t>(scene.scene().surfels.size());
    py::array_t<double> matrix({side, side});
    double* factors = matrix.mutable_data();
    const FormFactorOptions options{visibility, error, rays, epsilon, seed, tuning_with<FormFactorTuning>(tuning)};
    const FormFactors found = without_gil([&] { return form_factors(scene, options, factors, stages); });
    return py::make_tuple(matrix, to_array(found.rest), found.imprecise, found.rays);
}

// Per level, finest first, what Hierarchy::Level holds and the group of each surfel.
py::list hierarchy_of(const Surfels& surfels, const Indices& object, double epsilon, int max_levels, std::uint64_t seed,
                      const py::object& progress) {
    const HierarchyOptions options{epsilon, max_levels, seed};
    const std::vector<std::uint32_t> objects = to_vector<std::uint32_t>(object);
    const Progress report = to_progress(progress);
    const Hierarchy found = without_gil([&] { return build_hierarchy(surfels, objects, options, report); });
    py::list out;
    for (std::size_t k = 0; k < found.levels.size(); ++k) {
        const Hierarchy::Level& level = found.levels[k];
        py::dict figures;
        figures["groups"] = to_array(found.groups(k));
        figures["positions"] = to_array(level.positions);
        figures["normals"] = to_array(level.normals);
        figures["radii"] = to_array(level.radii);
        figures["areas"] = to_array(level.areas);
        figures["representatives"] = to_array(level.representatives);
        out.append(figures);
    }
    return out;
}

FormFactorOperator operator_of_scene(const CompiledScene& scene, int rays, std::uint64_t seed,
                                     const py::object& progress, const py::object& team) {
    const StageProgress stages = to_stage_progress(progress);
    const FormFactorOperatorOptions options{rays, seed, to_team(team)};
    return without_gil([&] { return form_factor_operator(scene, options, stages); });
}

FormFactorOperator operator_of_arrays(
    const py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>& begin, const Indices& met,
    const Indices& rays, const Indices& into_backs, const Doubles& areas, const Doubles& scale, const Doubles& escape,
    const Doubles& absorbed) {
    FormFactorOperator::State state;
    state.rows.begin.assign(begin.data(), begin.data() + begin.size());
    state.rows.met = to_vector(met);
    state.rows.rays = to_vector(rays);
    state.rows.into_backs = to_vector(into_backs);
    state.areas = to_vector(areas);
    state.scale = to_vector(scale);
    state.escape = to_vector(escape);
    state.absorbed = to_vector(absorbed);
    return FormFactorOperator(std::move(state));
}

// K x or K^T x of x (n, channels).
py::array_t<double> product(const FormFactorOperator& k, const Doubles& x, bool transposed) {
    require(x.ndim() == 2 && static_cast<std::size_t>(x.shape(0)) == k.size(), "x: wanted a row for each surfel");
    const std::vector<double> in = to_vector(x);
    const auto channels = static_cast<std::size_t>(x.shape(1));
    std::vector<double> out;
    without_gil([&] {
        if (transposed)
            k.apply_transposed(in, channels, out);
        else
            k.apply(in, channels, out);
        return 0;
    });
    return py::array_t<double>({x.shape(0), x.shape(1)}, out.data());
}

void bind_operator(py::module_& module) {
    // A view of a vector of the operator's, which lives as long.
    const auto view = [](const auto& vector, const py::object& self) {
        using Value = typename std::decay_t<decltype(vector)>::value_type;
        py::array_t<Value> out({static_cast<py::ssize_t>(vector.size())}, vector.data(), self);
        out.attr("flags").attr("writeable") = false;
        return out;
    };
    py::class_<FormFactorOperator> bound(module, "FormFactorOperator");
    bound
        .def(py::init(&operator_of_arrays), py::arg("begin"), py::arg("met"), py::arg("rays"), py::arg("into_backs"),
             py::arg("areas"), py::arg("scale"), py::arg("escape"), py::arg("absorbed"))
        .def("product", &product, py::arg("x"), py::arg("transposed"))
        .def(
            "variance",
            [](const FormFactorOperator& k, const Doubles& x) {
                const std::vector<double> in = to_vector(x);
                require(in.size() == k.size(), "x: wanted a value for each surfel");
                return to_array(without_gil([&] { return k.variance(in); }));
            },
            py::arg("x"));
    const auto property = [&](const char* name, const auto& get) {
        bound.def_property_readonly(name, [get, view](const py::object& self) {
            return view(get(self.cast<const FormFactorOperator&>().state()), self);
        });
    };
    using State = FormFactorOperator::State;
    property("begin", [](const State& s) -> const auto& { return s.rows.begin; });
    property("met", [](const State& s) -> const auto& { return s.rows.met; });
    property("rays", [](const State& s) -> const auto& { return s.rows.rays; });
    property("into_backs", [](const State& s) -> const auto& { return s.rows.into_backs; });
    property("areas", [](const State& s) -> const auto& { return s.areas; });
    property("scale", [](const State& s) -> const auto& { return s.scale; });
    property("escape", [](const State& s) -> const auto& { return s.escape; });
    property("absorbed", [](const State& s) -> const auto& { return s.absorbed; });
    module.def("form_factor_operator", &operator_of_scene, py::arg("scene"), py::arg("rays"), py::arg("seed"),
               py::arg("progress") = py::none(), py::arg("team") = py::none());
}

}  // namespace

void bind_radiosity(py::module_& module) {
    module.attr("PAIRS_UP_TO") = SolveOptions{}.pairs_up_to;
    module.def("require_memory_for_pairs", &require_memory_for_pairs, py::arg("surfels"), py::arg("limit"));
    module.def("solve", &solve_scene, py::arg("scene"), py::arg("transport"), py::arg("zeta"), py::arg("insert"),
               py::arg("max_surfels"), py::arg("tolerance"), py::arg("rays"), py::arg("probes"), py::arg("shadow_rays"),
               py::arg("epsilon"), py::arg("max_memory"), py::arg("seed"), py::arg("tuning") = TuningValues(),
               py::arg("progress") = py::none(), py::arg("team") = py::none());
    // Constants of all pairs, of global refinement and of form factors by name, as they are unless "tuning" sets them.
    module.def("pairs_tuning", &tuning_values<PairsTuning>);
    module.def("refinement_tuning", &tuning_values<RefinementTuning>);
    module.def("form_factor_tuning", &tuning_values<FormFactorTuning>);
    module.def("build_hierarchy", &hierarchy_of, py::arg("surfels"), py::arg("object"), py::arg("epsilon"),
               py::arg("max_levels"), py::arg("seed"), py::arg("progress") = py::none());
    module.def("form_factors", &form_factors_of_scene, py::arg("scene"), py::arg("visibility"), py::arg("error"),
               py::arg("rays"), py::arg("epsilon"), py::arg("seed"), py::arg("tuning") = TuningValues(),
               py::arg("progress") = py::none());
    bind_operator(module);
}

}  // namespace surflux::bindings
