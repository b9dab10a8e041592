#pragma once

#include <pybind11/pybind11.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <string>

#include "surflux/core/error.h"

namespace surflux::bindings {

namespace py = pybind11;

// Constants of a solver (radiosity/tuning.h, meshless/tuning.h) by name.
using TuningValues = std::map<std::string, double>;

template <class Tuning>
py::dict tuning_values() {
    py::dict out;
    Tuning().for_each([&](const char* name, double value) { out[name] = value; });
    return out;
}

// The constants as they are, but for those that are named.
template <class Tuning>
Tuning tuning_with(const TuningValues& values) {
    Tuning tuning;
    std::size_t known = 0;
    tuning.for_each([&](const char* name, double& value) {
        const auto given = values.find(name);
        if (given == values.end()) return;
        require(given->second > 0.0 && std::isfinite(given->second), "tuning: wanted ", name, " above 0, got ",
                given->second);
        value = given->second;
        ++known;
    });
    require(known == values.size(), "tuning: wanted names of the solver's own constants");
    return tuning;
}

}  // namespace surflux::bindings
