#include "solution_dict.h"

#include <cmath>

namespace surflux::bindings {

py::dict to_dict(const Figures& figures) {
    py::dict out;
    for (const auto& [name, value] : figures) {
        const bool whole = value == std::floor(value) && std::abs(value) < 9e15;
        if (whole && name != "error" && name != "residual" && name != "seconds")
            out[py::str(name)] = static_cast<long long>(value);
        else
            out[py::str(name)] = value;
    }
    return out;
}

StageProgress to_stage_progress(const py::object& callable) {
    return [shared = std::make_shared<py::object>(callable)](const std::string& stage) {
        return to_progress(shared, stage);
    };
}

py::dict to_dict(const Scene& scene, Solution&& solution) {
    py::list history;
    for (const Figures& figures : solution.history) history.append(to_dict(figures));
    py::dict timings;
    for (const auto& [name, seconds] : solution.timings) timings[py::str(name)] = seconds;
    py::dict out;
    std::vector<std::uint32_t> objects;
    objects.reserve(solution.parents.size());
    for (std::uint32_t parent : solution.parents) objects.push_back(scene.object[parent]);
    out["objects"] = handed_over(std::move(objects));
    solution.levels.resize(solution.parents.size(), 0);
    out["levels"] = handed_over(std::move(solution.levels));
    out["cut"] = solution.cut.empty() ? py::object(py::none()) : py::object(handed_over(std::move(solution.cut)));
    out["parents"] = handed_over(std::move(solution.parents));
    out["radiosity"] = handed_over(std::move(solution.radiosity));
    out["irradiance"] = handed_over(std::move(solution.irradiance));
    out["direct"] = handed_over(std::move(solution.direct));
    out["emitted"] =
        solution.emitted.empty() ? py::object(py::none()) : py::object(handed_over(std::move(solution.emitted)));
    out["error"] = solution.error;
    out["timings"] = timings;
    out["history"] = history;
    out["surfels"] = py::cast(std::move(solution.surfels));
    return out;
}

}  // namespace surflux::bindings
