#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/size_shares.h"
#include "surflux/lights/sample_points.h"
#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// The restriction of a basis to surfels, as a sparse matrix: row i holds the mean of each function over patch i, by up
// to 16 samples (64 on those partly inside geometry, where samples count 0, and on wide ones no fewer, by their share
// of the area), or its value at the centre of disk i. It is found once for a level; after that what surfels receive and
// send is a sparse product, where evaluating the basis at each ray's end took most of the time of L07 and of this
// solver, too.
class SurfelMeans {
public:
    struct Options {
        int levels;     // of the basis, at most
        double widest;  // patches are wide whose diameter exceeds so many times the coarsest spacing
        std::uint64_t seed;
        MeshlessTuning tuning = {};
    };
    // Of what is kept `basis` may have more levels later on: see extend(). `first_radius`: least distance of points on
    // its coarsest level, by object; it halves from level to level.
    SurfelMeans(const Scene& scene, const Tracer& tracer, const SurfelPoints& points, const MultilevelBasis& basis,
                const BasisSight& sight, const std::vector<double>& first_radius, const Options& options,
                const Progress& progress);

    // The rows of the level that the basis has got last. `spacing_level`: the level that its points are as far apart
    // as.
    void extend(std::size_t spacing_level, const Progress& progress);
    // MultilevelBasis::at_level at a place on a surfel, of the functions in its row, and on a wide patch of those that
    // the place sees; where there is none on the coarsest level, the row itself over outside(i).
    void at_level(std::size_t level, std::uint32_t i, const Vec3& point, std::vector<BasisWeight>& out) const;

    // The share of a surfel that is not inside geometry. There is no light inside, where no points are (L07 6.1).
    double outside(std::size_t i) const { return outside_[i]; }
    // Of those of its places that tell the mean of a coarsest level, the ones that are not inside geometry.
    void outside_places(std::uint32_t i, std::vector<Departure>& out) const;
    // Is a surfel so large, beside what the coarsest level can tell apart, that its mean says little of its parts?
    bool is_wide(std::uint32_t i) const;

    // Calls visit(function, weight) for all that are not zero on a surfel, coarse levels first.
    template <class Visit>
    void for_functions(std::size_t i, const Visit& visit) const {
        for (const Rows& rows : levels_)
            for (std::uint32_t k = rows.begin[i]; k < rows.begin[i + 1]; ++k)
                visit(rows.entries[k].function, static_cast<double>(rows.entries[k].weight));
    }
    // How many those are of all surfels together.
    std::size_t weights() const {
        std::size_t sum = forgotten_;
        for (const Rows& rows : levels_) sum += rows.entries.size();
        return sum;
    }
    // There is no function on any surfel afterwards; outside() and weights() are as before.
    void forget_weights() {
        forgotten_ = weights();
        levels_ = {};
    }
    Rgb mean(std::size_t i, const std::vector<Rgb>& coefficients) const {
        Rgb sum;
        for_functions(i, [&](std::uint32_t j, double weight) { sum += weight * coefficients[j]; });
        return sum;
    }

private:
    struct Entry {
        std::uint32_t function;
        float weight;
    };
    struct Rows {
        std::vector<std::uint32_t> begin;  // of each surfel, and the end
        std::vector<Entry> entries;
    };
    int all_places() const { return static_cast<int>(options_.tuning.all_places); }
    int count_for(std::uint32_t i, std::size_t level) const;
    void places_on(std::uint32_t i, int count, std::vector<Departure>& out) const;
    const std::vector<char>* partly_inside(std::uint32_t i) const;

    const Scene& scene_;
    const Tracer& tracer_;
    const SurfelPoints& points_;
    const MultilevelBasis& basis_;
    const BasisSight& sight_;
    std::vector<double> first_radius_;
    Options options_;
    std::vector<double> outside_;
    struct PartlyInside {
        std::uint32_t surfel;
        std::vector<char> inside;  // each of its places
    };
    std::vector<PartlyInside> partly_inside_;  // by surfel
    SizeShares wide_;                          // areas of wide patches
    std::vector<Rows> levels_;
    std::size_t forgotten_ = 0;  // weights
};

}  // namespace surflux
