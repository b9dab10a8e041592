#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/random.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/gathered_system.h"
#include "surflux/radiosity/gathering.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

// Refinement oracle: finds the nodes of a cut between which the interpolation error is too large. D04 7.1 refines where
// neighbours differ; as fields are interpolated to first order, what is asked here is
//   - how close by surfaces are that do not all send the same: they change the field within their distance (Ward and
// others 1988), to first order by its square;
//   - what the nodes around would say at the node, and all of them at other surfels below it, one drawn at random and
// some at its corners, at which a few rays know better. So groups are found out that a surfel stands for which is not
// like the rest, or that have light of the sky there in place of what surfaces reflect.
class CutTest {
public:
    // What each node may be off by, in luminance, if it is of the usual area; smaller ones may more, as area^-1/4.
    struct Allowed {
        std::vector<double> error;  // by interpolation
        std::vector<double> noise;  // of its rays
    };
    struct Result {
        std::vector<char> refine;  // of each node
        std::vector<int> rays;     // that each node wants, where those that it has are too few to tell; else 0
        double error = 0.0;        // estimated, of the whole field: relative RMS
    };

    // `probes` takes the rays to surfels below groups.
    CutTest(const SurfelTree& tree, const Gathering& gathering, Gathering& probes, std::uint64_t seed,
            const RefinementTuning& tuning = {});

    // `values`: the solution on the cut, and `sent` what all nodes of the tree send by it. `reference`: luminance of
    // the RMS of H. `most_rays`: of a node. All nodes are asked each time: one that saw nothing of what is small and
    // bright learns of it by those around it, once they have given way to their members.
    Result operator()(const Cut& cut, const GatheredSystem& system, const std::vector<double>& values,
                      const std::vector<double>& sent, const Allowed& allowed, const std::vector<double>& arrived,
                      double reference, double usual_area, int most_rays, const Progress& progress);
    struct Noise {
        std::vector<double> standard_error;  // of each node, from the halves of its rays and those of nodes around
        std::vector<int> rays;               // that it wants, where that is more than is allowed; else 0
    };
    Noise rays_wanted(const Cut& cut, const GatheredSystem& system, const std::vector<double>& sent,
                      const Allowed& allowed, double usual_area, int most_rays, const Progress& progress) const;
    // Standard error of the luminance of a row, from its two halves.
    static double standard_error(const Gathering& gathering, std::uint32_t row, const GatheredSystem& system,
                                 const std::vector<double>& sent);

private:
    std::uint32_t leaf_below(std::uint32_t node, Random& random) const;
    std::vector<std::uint32_t> telling_leaves(std::uint32_t node) const;
    void probe(const Cut& cut, const Progress& progress);

    const SurfelTree& tree_;
    const Gathering& gathering_;
    Gathering& probes_;
    std::uint64_t seed_;
    RefinementTuning tuning_;
    struct Probes {
        std::uint32_t first, count;  // rows
    };
    std::unordered_map<std::uint32_t, Probes> probes_of_;  // of groups
};

}  // namespace surflux
