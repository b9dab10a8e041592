#pragma once

#include <memory>
#include <string>
#include <vector>

#include "convert.h"
#include "surflux/core/team.h"

namespace surflux::bindings {

// None, or an object with `rank`, `size` and exchange(pass, mine) -> list of bytes, which calls mine() -> bytes where
// it does not know the results. Passes call it with the GIL released, on the thread that called them.
inline Team to_team(const py::object& team) {
    if (team.is_none()) return {};
    Team out;
    out.rank = team.attr("rank").cast<std::size_t>();
    out.size = team.attr("size").cast<std::size_t>();
    require(out.rank < out.size, "team: wanted a rank below its size ", out.size, ", got ", out.rank);
    // Shared, not copied: copies are made without the GIL, and the last one is let go with it.
    const std::shared_ptr<py::object> exchange(new py::object(team.attr("exchange")), [](py::object* of) {
        const py::gil_scoped_acquire gil;
        delete of;
    });
    out.exchange = [exchange](const std::string& pass, const Team::Mine& mine) {
        const py::gil_scoped_acquire gil;
        const py::cpp_function make([&mine] { return py::bytes(without_gil(mine)); });
        std::vector<std::string> all;
        for (const py::handle one : py::list((*exchange)(pass, make))) all.push_back(one.cast<py::bytes>());
        return all;
    };
    return out;
}

}  // namespace surflux::bindings
