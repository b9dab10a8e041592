#include "surflux/radiosity/insertion_after.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/write_leaves.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

// Marks surfels around which emitters' light is better interpolated from the exchange between surfels, which has no
// noise, than found by rays: these are off by more than is wanted, and by more than interpolation is.
std::vector<char> noisy_emitters(const Surfels& s, const std::vector<std::uint32_t>& objects,
                                 const Interpolation& sites, const std::vector<Rgb>& exact,
                                 const std::vector<Rgb>& missing, double wanted, const PairsTuning& tuning,
                                 const Progress& progress) {
    const std::size_t around = whole_number(tuning.surfels_around);
    std::vector<double> noise(s.size()), bend(s.size());
    std::vector<char> out(s.size(), 0);
    const auto near_each = [&](const auto& body) {
        parallel_blocks(
            s.size(), 64,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Interpolation::Weight> near;
                for (std::size_t i = begin; i < end; ++i) {
                    sites.nearest(s.positions[i], s.normals[i], objects[i], around, near);
                    body(i, near);
                }
            },
            progress);
    };
    near_each([&](std::size_t i, const std::vector<Interpolation::Weight>& near) {
        Rgb others;
        double squared = 0.0;
        for (const Interpolation::Weight& other : near) {
            squared += luminance(missing[other.site]) * luminance(missing[other.site]);
            if (other.site != i) others += exact[other.site];
        }
        const auto count = static_cast<double>(near.size());
        noise[i] = std::sqrt(squared / count);
        bend[i] = count > 1.0 ? std::abs(luminance(others) / (count - 1.0) - luminance(exact[i])) : 0.0;
    });
    near_each([&](std::size_t i, const std::vector<Interpolation::Weight>& near) {
        double squared = 0.0;
        for (const Interpolation::Weight& other : near) squared += bend[other.site] * bend[other.site];
        const double interpolated = tuning.between_places * std::sqrt(squared / static_cast<double>(near.size()));
        out[i] = noise[i] > std::max(wanted, interpolated);
    });
    return out;
}

}  // namespace

void insert_after(const Scene& scene, const Tracer& tracer, double zeta, const PairsTuning& tuning, SurfelTree& tree,
                  LitPoints& lit, const Progress& progress, Solution& solution) {
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    Stopwatch watch(solution.timings);
    // What is interpolated: of direct light what is not in `lit`, the same of emitters' light, and all else.
    std::vector<Rgb> direct(n), emitted(n), others(n);
    double squared = 0.0, total = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const Rgb from_emitters = solution.emitted.empty() ? Rgb{} : solution.emitted[i];
        direct[i] = solution.direct[i] - lit.from_lights(i);
        emitted[i] = from_emitters - lit.from_emitters(i);
        others[i] = solution.irradiance[i] - solution.direct[i] - from_emitters;
        const double h = luminance(solution.irradiance[i]);
        squared += s.areas[i] * h * h;
        total += s.areas[i];
    }
    const double wanted = zeta * std::sqrt(squared / total);
    const Sight sight(tracer, scene);
    std::vector<Rgb> light(n);
    for (std::size_t i = 0; i < n; ++i) light[i] = direct[i] + emitted[i] + others[i];
    const NodalField field(s.positions, s.normals, scene.object, {}, tuning.nodal);
    const bool has_emitters = !solution.emitted.empty();
    const std::vector<char> is_noisy = has_emitters
                                           ? noisy_emitters(s, scene.object, field.interpolation(), solution.emitted,
                                                            emitted, wanted, tuning, progress)
                                           : std::vector<char>();
    const NodalField::Values exact_field =
        has_emitters ? field.fit(solution.emitted, &sight, progress) : NodalField::Values{};
    const NodalField::Values direct_field = field.fit(direct, &sight, progress),
                             emitted_field = field.fit(emitted, &sight, progress),
                             other_field = field.fit(others, &sight, progress);

    Insertion insertion(tree, {smallest_radius(s)});
    const auto value = [&](std::uint32_t p) { return luminance(lit[p] + direct[p] + emitted[p] + others[p]); };
    const auto allowed = [&](std::uint32_t p) {
        return wanted + RefinementTuning{}.significance * lit.standard_error(p);
    };
    const auto interpolate = [&] {
        lit.update(progress);
        const std::size_t before = direct.size();
        direct.resize(tree.points());
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
                    direct[k] = field.at(direct_field, tree.position(p), tree.normal(p), near);
                    emitted[k] =
                        has_emitters && is_noisy[tree.surfel(p)]
                            ? field.at(exact_field, tree.position(p), tree.normal(p), near) - lit.from_emitters(p)
                            : field.at(emitted_field, tree.position(p), tree.normal(p), near);
                    others[k] = field.at(other_field, tree.position(p), tree.normal(p), near);
                }
            },
            progress);
    };
    insertion.refine_all(value, allowed, interpolate, progress);
    if (tree.points() > n) {
        const std::vector<std::uint32_t> leaves = tree.all_leaves();
        solution.direct.resize(leaves.size());
        solution.irradiance.resize(leaves.size());
        solution.levels.resize(leaves.size());
        if (!solution.emitted.empty()) solution.emitted.resize(leaves.size());
        for (std::size_t k = 0; k < leaves.size(); ++k) {
            const std::uint32_t p = leaves[k];
            Rgb from_emitters = lit.from_emitters(p) + emitted[p];
            for (int c = 0; c < 3; ++c) from_emitters[c] = std::max(0.0, from_emitters[c]);
            solution.direct[k] = lit.from_lights(p) + direct[p];
            solution.irradiance[k] = solution.direct[k] + from_emitters + others[p];
            solution.levels[k] = tree.level(p);
            if (!solution.emitted.empty()) solution.emitted[k] = from_emitters;
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
