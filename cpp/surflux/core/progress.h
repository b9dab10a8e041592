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

// The same from a loop on one thread: now and then, where `every` steps take a few milliseconds.
inline void report_some(const Progress& progress, std::size_t done, std::size_t total, std::size_t every) {
    if (done % every == 0) report(progress, done, total);
}

// For loops within a pass whose steps are none that it counts: they ask whether to go on, and tell where the pass
// stands.
inline Progress standing_at(std::size_t done, std::size_t total, const Progress& progress) {
    if (!progress) return {};
    return [progress, done, total](std::size_t, std::size_t) { return progress(done, total); };
}

// Told the stage that begins; its own progress follows.
using StageProgress = std::function<Progress(const std::string& stage)>;

}  // namespace surflux
