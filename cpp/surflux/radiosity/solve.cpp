#include "surflux/radiosity/solve.h"

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/radiosity/global_refinement.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/insertion_after.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/radiosity/pairs_solve.h"
#include "surflux/solution/self_check.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

Solution solve(const CompiledScene& compiled, const SolveOptions& options, const StageProgress& progress) {
    const Scene& scene = compiled.scene();
    const std::size_t n = scene.surfels.size();
    require(n > 0, "scene: it has no surfels");
    require_areas(scene);
    require(options.tolerance > 0.0 && options.tolerance < 1.0, "tolerance: wanted in (0, 1), got ", options.tolerance);
    require(options.rays >= 16 && options.rays <= 65535, "rays: wanted 16 to 65535, got ", options.rays);
    require(options.zeta > 0.0, "zeta: wanted more than 0, got ", options.zeta);
    const bool by_pairs = options.transport == Transport::pairs ||
                          (options.transport == Transport::automatic && n <= options.pairs_up_to);

    Solution out;
    Stopwatch watch(out.timings);
    const Tracer& tracer = compiled.tracer(progress ? progress("trace") : Progress{});
    watch.lap("trace");
    if (by_pairs) {
        const SurfelPoints points(scene.surfels);
        const LightSampler emitters = LightSampler::of_surfels(scene);
        const SkyCells sky(scene.lights);
        SurfelTree tree(scene, {}, leaves_allowed(scene, options.insert, options.max_surfels));
        // Emitters' light is exchanged as all light is; only at inserted surfels it is found by itself.
        LitPoints lit(scene, points, tracer, tree, options.insert ? &emitters : nullptr, &sky, options.direct,
                      options.rays, options.seed);
        lit.update(progress ? progress("direct") : Progress{});
        watch.lap("direct");
        solve_by_pairs(scene, tracer, lit, {options.tolerance, options.rays, options.exchange, options.seed}, progress,
                       out);
        if (options.insert)
            insert_after(scene, tracer, options.zeta, options.exchange.tuning, tree, lit,
                         progress ? progress("insertion") : Progress{}, out);
    } else {
        RefinementOptions refinement;
        refinement.zeta = options.zeta;
        refinement.insert = options.insert;
        refinement.max_surfels = options.max_surfels;
        refinement.tolerance = options.tolerance;
        refinement.epsilon = options.exchange.epsilon;
        refinement.rays = options.rays;
        refinement.direct = options.direct;
        refinement.seed = options.seed;
        refinement.tuning = options.tuning;
        refinement.team = options.team;
        solve_by_gathering(scene, tracer, refinement, progress, out);
    }
    give_back_memory();
    check_solution(scene, tracer, options.seed, progress ? progress("self-check") : Progress{}, out, options.team,
                   by_pairs ? options.exchange.tuning.self_check : options.tuning.self_check);
    return out;
}

}  // namespace surflux
