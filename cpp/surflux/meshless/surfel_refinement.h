#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/meshless/oracle.h"
#include "surflux/meshless/surface_light.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/reciprocal_scaling.h"

namespace surflux {

// A last level without a basis: final gathering at surfels where the basis is still off on its finest level. They are
// those whose finest coefficients, and coarser ones as far as these are no part of them, exceed half the oracle's
// tolerance; of the others the largest where 16 rays, and the brightest where their full number of rays, contradict the
// basis: features between its points have no coefficient that could tell.
class SurfelRefinement {
public:
    struct Options {
        double epsilon_e;
        int rays;        // of a surfel, at most
        bool reflected;  // is any bounce wanted?
    };
    // `coefficients`: of the irradiance that surfaces reflect.
    SurfelRefinement(const Scene& scene, const SurfaceLight& light, const SurfelMeans& means, const Oracle& oracle,
                     const std::vector<Rgb>& coefficients, const Options& options, HemisphereGather& gather);

    void run(const Progress& progress);

    // The surfels that have rays of their own, and what these found: the irradiance of the light that the basis holds
    // elsewhere, and what met nothing or backs.
    struct Found {
        MeshlessField::At light;
        HemisphereLoss loss;
    };
    const std::vector<std::uint32_t>& surfels() const { return surfels_; }
    const std::vector<Found>& found() const { return found_; }

private:
    std::vector<Found> gather(const std::vector<std::uint32_t>& surfels, const std::vector<int>& counts,
                              const Progress& progress);
    double allowed(std::uint32_t surfel) const;
    int least_rays() const { return std::max(1, static_cast<int>(tuning_.least_own_rays)); }
    int rays_for(std::uint32_t surfel) const;
    std::vector<int> rays_for(const std::vector<std::uint32_t>& surfels) const;
    bool is_off(std::uint32_t surfel) const;
    bool is_bright(std::uint32_t surfel) const;
    bool contradicted(std::uint32_t surfel, const MeshlessField::At& found, int rays) const;
    std::vector<std::uint32_t> largest(const std::vector<char>& candidates, std::size_t count) const;

    const Scene& scene_;
    const SurfaceLight& light_;
    const SurfelMeans& means_;
    const Oracle& oracle_;
    const MeshlessTuning& tuning_;
    const std::vector<Rgb>& coefficients_;
    Options options_;
    Oracle::Wanted wanted_;
    HemisphereGather& gather_;
    std::vector<Rgb> sent_;
    std::vector<std::uint32_t> surfels_;
    std::vector<Found> found_;
};

}  // namespace surflux
