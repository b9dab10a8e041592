#pragma once

#include "surflux/core/progress.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Inserts surfels into a solution on the scene's own, where its field asks for them (D04 7.2), by more than zeta of the
// RMS of H. What comes to them from lights, images of the sky and small emissive surfels `lit` finds, which is of
// `tree`; all else is interpolated, and so is the difference between what `solution` has of these and what `lit` has at
// the scene's own surfels.
void insert_after(const Scene& scene, const Tracer& tracer, double zeta, const PairsTuning& tuning, SurfelTree& tree,
                  LitPoints& lit, const Progress& progress, Solution& solution);

}  // namespace surflux
