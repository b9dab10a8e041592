#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/direct.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/meshless/tuning.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

struct MeshlessOptions {
    int levels = 6;           // of the basis, at most
    double radius = 0.0;      // of the Poisson disks of the first; 0: by the size of each object
    double epsilon_e = 0.04;  // what a receiver may be off by before it is refined, of the RMS of what is solved for
    double epsilon_omega = 0.314;  // of senders, in steradians
    int rays = 512;                // of a receiver
    int bounces = -1;              // fewer than 0: all
    bool indirect_only = true;     // else what lights bring is in the basis; what emissive surfels bring never is
    double tolerance = 1e-4;       // of the linear system, where all bounces are wanted
    DirectOptions direct;
    std::uint64_t seed = 0;
    Team team = {};  // of processes that share out what is expensive
    MeshlessTuning tuning = {};
};

struct MeshlessSolution {
    Solution solution;  // at the scene's own surfels
    std::shared_ptr<const MeshlessField> field;
    std::vector<Rgb> lit;  // of solution.direct, what is not in the basis; solution.emitted never is
};

// Hierarchical radiosity in a meshless basis (L07 6.3): light is gathered at points of the coarsest level; where
// neighbours there differ, or a coefficient of a finer level is large, at the points of the next level around it. What
// departs from L07:
//   - points of finer levels are placed where they are wanted, not everywhere;
//   - a receiver's rays are shot once (hemisphere_gather.h), and bounces summed by GMRES unless their number is given;
//   - by default, as L07 recommends, direct light is not in the basis, and what surfaces reflect of it is taken where
//     rays meet them;
//   - surfels send and receive by the means of functions over them (surfel_means.h): the basis is hardly evaluated;
//   - where it is off on its last level, surfels have light of their own (surfel_refinement.h);
//   - finer receivers have fewer rays, and may be off by more: they speak for less of the surface (oracle.h);
//   - supports end at walls (wall_cuts.h) and weigh normals more sharply (shepard_level.h); levels fade out at their
//   rims, and the slope of coarser ones counts as far as values around bear it out (level_light.h);
//   - clouds have points at the centres of their disks alone; those as dense as the disks come twice more, as levels
//   of residuals (placed_basis.h) with the rows that they have;
//   - energy that the weights lose is given back where they lose it (meshless_exchange.h), unless the number of bounces
//   is given.
// Words of this room: a function is one of the basis, and its point the place around which it is; a receiver is a
// function at whose point light is gathered, its row what its rays met, and senders the surfels among that; a place is
// where light is asked for, on any surfel; an object is one of the scene's, within which alone light is interpolated.
MeshlessSolution solve_meshless(const CompiledScene& compiled, const MeshlessOptions& options,
                                const StageProgress& progress);

}  // namespace surflux
