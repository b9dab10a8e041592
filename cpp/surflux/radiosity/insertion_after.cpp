#include "surflux/radiosity/insertion_after.h"

#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/radiosity/write_leaves.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

void insert_after(const Scene& scene, const Tracer& tracer, const InsertionAfterOptions& options,
                  const Progress& progress, Solution& solution) {
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    Stopwatch watch(solution.timings);
    SurfelTree tree(scene, {}, leaves_allowed(scene, true, options.max_surfels));
    const SurfelPoints points(s);
    LitPoints lit(scene, points, tracer, tree, nullptr, nullptr, options.direct, 0, options.seed);
    lit.update(progress);
    // What is interpolated: of direct light, from emitters, and all else.
    std::vector<Rgb> sky(n), others(n), emitted = solution.emitted;
    emitted.resize(n);
    double squared = 0.0, total = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        sky[i] = solution.direct[i] - lit.from_lights(i);
        others[i] = solution.irradiance[i] - solution.direct[i] - emitted[i];
        const double h = luminance(solution.irradiance[i]);
        squared += s.areas[i] * h * h;
        total += s.areas[i];
    }
    const double wanted = options.zeta * std::sqrt(squared / total);
    const Sight sight(tracer, scene);
    std::vector<double> light(n);
    for (std::size_t i = 0; i < n; ++i) light[i] = luminance(sky[i] + emitted[i] + others[i]);
    const NodalField field(s.positions, s.normals, scene.object);
    const NodalField::Values sky_field = field.fit(sky, &sight, progress),
                             emitted_field = field.fit(emitted, &sight, progress),
                             other_field = field.fit(others, &sight, progress);

    Insertion insertion(tree, {smallest_radius(s)});
    const auto value = [&](std::uint32_t p) { return luminance(lit.from_lights(p) + sky[p] + emitted[p] + others[p]); };
    const auto allowed = [&](std::uint32_t p) {
        return wanted + RefinementTuning{}.significance * lit.standard_error(p);
    };
    for (int round = 0; round < Insertion::most_rounds && insertion.refine(value, allowed, progress); ++round) {
        lit.update(progress);
        const std::size_t before = sky.size();
        sky.resize(tree.points());
        others.resize(tree.points());
        emitted.resize(tree.points());
        parallel_blocks(
            tree.points() - before, 64,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Interpolation::Weight> near;
                for (std::size_t k = before + begin; k < before + end; ++k) {
                    const auto p = static_cast<std::uint32_t>(k);
                    field.interpolation().at(tree.position(p), tree.normal(p), tree.object(p), near);
                    if (!sight.keep_joined(tree.position(p), tree.normal(p), field.sites(), light, near))
                        near.assign(1, {tree.surfel(p), 1.0});
                    sky[k] = field.at(sky_field, tree.position(p), tree.normal(p), near);
                    emitted[k] = field.at(emitted_field, tree.position(p), tree.normal(p), near);
                    others[k] = field.at(other_field, tree.position(p), tree.normal(p), near);
                }
            },
            progress);
    }
    if (tree.points() > n) {
        const std::vector<std::uint32_t> leaves = tree.all_leaves();
        solution.direct.resize(leaves.size());
        solution.irradiance.resize(leaves.size());
        solution.levels.resize(leaves.size());
        if (!solution.emitted.empty()) solution.emitted.resize(leaves.size());
        for (std::size_t k = 0; k < leaves.size(); ++k) {
            solution.direct[k] = lit.from_lights(leaves[k]) + sky[leaves[k]];
            solution.irradiance[k] = solution.direct[k] + emitted[leaves[k]] + others[leaves[k]];
            solution.levels[k] = tree.level(leaves[k]);
            if (!solution.emitted.empty()) solution.emitted[k] = emitted[leaves[k]];
        }
        write_leaves(tree, leaves, solution);
        for (auto& [name, figure] : solution.history.back()) {
            if (name == "surfels") figure = static_cast<double>(tree.leaves());
            if (name == "inserted") figure = static_cast<double>(tree.points() - n);
        }
    }
    solution.history.back().emplace_back("left_out", static_cast<double>(insertion.left_out()));
    watch.lap("insertion");
}

}  // namespace surflux
