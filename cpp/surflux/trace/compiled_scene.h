#pragma once

#include <memory>
#include <mutex>

#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// A scene as all passes over it share it: it no longer changes, and has one tracer, built for the first that asks. So
// what follows a solve - light anywhere, pictures, a reference, another solve - starts at once. Any number of threads
// may use it.
class CompiledScene {
public:
    CompiledScene(Scene scene) : scene_(std::move(scene)) {}  // NOLINT: a scene that is handed to a solver compiles

    const Scene& scene() const { return scene_; }
    // Where it is built, `progress` is told of that, and may cancel it: the next that asks builds it anew.
    const Tracer& tracer(const Progress& progress = {}) const {
        std::call_once(traced_, [&] { tracer_ = std::make_unique<Tracer>(scene_, progress); });
        return *tracer_;
    }

private:
    const Scene scene_;
    mutable std::once_flag traced_;
    mutable std::unique_ptr<Tracer> tracer_;
};

}  // namespace surflux
