#pragma once

#include "convert.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"

// What every solver gives, for Python.
namespace surflux::bindings {

py::dict to_dict(const Figures& figures);
py::dict to_dict(const Scene& scene, Solution&& solution);

// Python is told (stage, done, total).
StageProgress to_stage_progress(const py::object& callable);

}  // namespace surflux::bindings
