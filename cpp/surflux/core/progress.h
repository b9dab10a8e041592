#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "surflux/core/error.h"

namespace surflux {

// (done, total) -> go on? Called on the thread that called the pass, between its parallel blocks.
using Progress = std::function<bool(std::size_t done, std::size_t total)>;

inline void report(const Progress& progress, std::size_t done, std::size_t total) {
    if (progress && !progress(done, total)) throw Cancelled();
}

// Told the stage that begins; its own progress follows.
using StageProgress = std::function<Progress(const std::string& stage)>;

}  // namespace surflux
