#include "surflux/meshless/surfel_refinement.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

SurfelRefinement::SurfelRefinement(const Scene& scene, const SurfaceLight& light, const SurfelMeans& means,
                                   const Oracle& oracle, const std::vector<Rgb>& coefficients, const Options& options,
                                   HemisphereGather& gather)
    : scene_(scene),
      light_(light),
      means_(means),
      oracle_(oracle),
      tuning_(oracle.tuning),
      coefficients_(coefficients),
      options_(options),
      wanted_(oracle.wanted(oracle.tuning.stricter * options.epsilon_e)),
      gather_(gather) {
    gather_.sent(coefficients_, sent_);
    for (Rgb& rgb : sent_)
        for (int c = 0; c < 3; ++c) rgb[c] = std::max(0.0, rgb[c]);
}

// Of the light that the basis has, all.
std::vector<SurfelRefinement::Found> SurfelRefinement::gather(const std::vector<std::uint32_t>& surfels,
                                                              const std::vector<int>& counts,
                                                              const Progress& progress) {
    const Surfels& s = scene_.surfels;
    std::vector<Place> places;
    for (const std::uint32_t i : surfels) places.push_back({s.positions[i], s.normals[i], i, i});
    std::vector<Found> out;
    for (const auto& [row, gathered] : gather_.once(places, counts, coefficients_, sent_, progress)) {
        const std::uint32_t i = surfels[out.size()];
        MeshlessField::At light{row.scaled_sky() + row.emitted_scale * row.emitted, row.scaled_sky()};
        if (options_.reflected) light.all += row.first_scale * row.first_bounce + gathered;
        if (light_.lights_in_basis()) {
            light.all += light_.direct_at_surfel(i);
            light.direct += light_.direct_at_surfel(i);
        }
        light.clamp();
        const double variance = s.areas[i] * variance_of_share(row.met(), static_cast<double>(row.rays));
        out.push_back({light, {row.escape, row.into_backs, 0.0, variance}});
    }
    return out;
}

// A surfel is as a point of the level on which these are as far apart as it is large.
double SurfelRefinement::allowed(std::uint32_t surfel) const {
    const double spacing = oracle_.first_radius[scene_.object[surfel]];
    return Oracle::allowed_at(0.5 * std::log2(spacing * spacing / std::max(scene_.surfels.areas[surfel], 1e-300)));
}

int SurfelRefinement::rays_for(std::uint32_t surfel) const {
    const double spacing = oracle_.first_radius[scene_.object[surfel]];
    const double across = std::sqrt(scene_.surfels.areas[surfel]) / spacing;
    const double share =
        std::clamp(across * across, std::min(1.0, tuning_.own_in_a_row * across), tuning_.most_for_wide);
    return std::max(std::min(options_.rays, least_rays()), static_cast<int>(std::lround(options_.rays * share)));
}

std::vector<int> SurfelRefinement::rays_for(const std::vector<std::uint32_t>& surfels) const {
    std::vector<int> out;
    for (const std::uint32_t i : surfels) out.push_back(rays_for(i));
    return out;
}

// By what the finest functions on it differ by from coarser ones; where these have a part in it alone, as at the rim of
// what was refined, by what coarser ones do, for the rest.
bool SurfelRefinement::is_off(std::uint32_t surfel) const {
    std::size_t finest = 0;
    MeshlessField::At light;
    double off = 0.0, off_sent = 0.0, coarser = 0.0, coarser_sent = 0.0, share = 0.0;
    bool any = false;
    means_.for_functions(surfel, [&](std::uint32_t j, double weight) {
        if (!oracle_.receivers.has(j)) return;
        any = true;
        if (const std::size_t level = oracle_.basis.level_of(j); level > finest) {
            coarser = finest > 0 ? off + (1.0 - share) * coarser : 0.0;
            coarser_sent = finest > 0 ? off_sent + (1.0 - share) * coarser_sent : 0.0;
            finest = level, off = off_sent = share = 0.0;
        }
        const Rgb& c = oracle_.field.coefficients[j];
        const Rgb c_sent = c - oracle_.field.direct[j];
        light.all += weight * c, light.direct += weight * oracle_.field.direct[j];
        off += weight * color_norm(c), off_sent += weight * color_norm(c_sent);
        share += weight;
    });
    if (!any) return means_.outside(surfel) > 0.0;
    off += (1.0 - std::min(1.0, share)) * coarser, off_sent += (1.0 - std::min(1.0, share)) * coarser_sent;
    light.clamp();
    const double all = color_norm(light.all), sent = color_norm(light.all - light.direct);
    // On the coarsest level coefficients are no differences: what they are off by has been asked for its points.
    if (finest == 0) return false;
    const Oracle::Wanted here = wanted_.times(allowed(surfel)).at(all);
    const double root = std::sqrt(static_cast<double>(rays_for(surfel)));
    return off > std::max(here.of_all, tuning_.ray_error / root * all) ||
           off_sent >
               std::max({here.of_sent, tuning_.ray_error / root * sent, tuning_.ray_error_of_skies / root * all});
}

bool SurfelRefinement::is_bright(std::uint32_t surfel) const {
    const double sent =
        color_norm(means_.mean(surfel, oracle_.field.coefficients) - means_.mean(surfel, oracle_.field.direct));
    return tuning_.stricter * options_.epsilon_e * sent > tuning_.bright * wanted_.of_sent;
}

bool SurfelRefinement::contradicted(std::uint32_t surfel, const MeshlessField::At& found, int rays) const {
    const double root = std::sqrt(static_cast<double>(rays));
    const auto farther = [&](const Rgb& a, const Rgb& b, double may_be) {
        return color_norm(a - b) > may_be + tuning_.ray_error_of_few / root * std::max(color_norm(a), color_norm(b));
    };
    const Rgb all = means_.mean(surfel, oracle_.field.coefficients), direct = means_.mean(surfel, oracle_.field.direct);
    const Oracle::Wanted here = wanted_.times(allowed(surfel)).at(color_norm(found.all));
    return farther(all, found.all, here.of_all) || farther(all - direct, found.all - found.direct, here.of_sent);
}

// Of the candidates that are not inside geometry.
std::vector<std::uint32_t> SurfelRefinement::largest(const std::vector<char>& candidates, std::size_t count) const {
    const std::vector<double>& areas = scene_.surfels.areas;
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < areas.size(); ++i)
        if (candidates[i] && means_.outside(i) > 0.0 && areas[i] > 0.0) out.push_back(i);
    if (out.size() > count) {
        std::nth_element(
            out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count), out.end(),
            [&](std::uint32_t a, std::uint32_t b) { return areas[a] > areas[b] || (areas[a] == areas[b] && a < b); });
        out.resize(count);
        std::sort(out.begin(), out.end());
    }
    return out;
}

void SurfelRefinement::run(const Progress& progress) {
    const auto n = static_cast<std::uint32_t>(scene_.surfels.size());
    std::vector<char> off(n), bright_ones(n), neither(n);
    parallel_for(n, 256, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        off[i] = is_off(i);
        bright_ones[i] = !off[i] && is_bright(i);
        neither[i] = !off[i] && !bright_ones[i];
    });
    const std::size_t rays = static_cast<std::size_t>(tuning_.trying_share * static_cast<double>(gather_.rays()));
    const int trying_rays = std::max(1, static_cast<int>(tuning_.trying_rays));
    const std::vector<std::uint32_t> tried = largest(neither, rays / static_cast<std::size_t>(trying_rays));
    const std::vector<Found> by_few = gather(tried, std::vector<int>(tried.size(), trying_rays), progress);
    for (std::size_t k = 0; k < tried.size(); ++k) off[tried[k]] = contradicted(tried[k], by_few[k].light, trying_rays);
    for (std::uint32_t i = 0; i < n; ++i)
        if (off[i]) surfels_.push_back(i);
    found_ = gather(surfels_, rays_for(surfels_), progress);
    std::vector<std::uint32_t> doubted = largest(bright_ones, rays / static_cast<std::size_t>(least_rays()));
    std::vector<int> counts = rays_for(doubted);
    std::size_t taken = 0, spent = 0;
    for (; taken < doubted.size() && (taken == 0 || spent + static_cast<std::size_t>(counts[taken]) <= rays); ++taken)
        spent += static_cast<std::size_t>(counts[taken]);
    doubted.resize(taken);
    counts.resize(taken);
    const std::vector<Found> found = gather(doubted, counts, progress);
    for (std::size_t k = 0; k < doubted.size(); ++k) {
        if (!contradicted(doubted[k], found[k].light, counts[k])) continue;
        surfels_.push_back(doubted[k]);
        found_.push_back(found[k]);
    }
}

}  // namespace surflux
