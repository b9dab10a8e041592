#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/sample_points.h"
#include "surflux/meshless/basis_sight.h"
#include "surflux/scene/scene.h"
#include "surflux/transfer/row_shooter.h"
#include "surflux/transfer/row_test.h"
#include "surflux/transfer/shot_rows.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {

// Surfels that need rows of their own beside those of a basis: on which rays contradict it.
struct ContradictedSurfels {
    std::vector<std::uint32_t> surfels;
    std::vector<float> received;  // RowTest::size() values of each
    std::vector<float> variance;  // their mean square standard error
    std::vector<double> error;    // mean square of what the basis is off by, times the area

    template <class Visit>
    void for_each(const Visit& visit) {
        visit(surfels), visit(received), visit(variance), visit(error);
    }
    void append(const ContradictedSurfels& others) {
        surfels.insert(surfels.end(), others.surfels.begin(), others.surfels.end());
        received.insert(received.end(), others.received.begin(), others.received.end());
        variance.insert(variance.end(), others.variance.begin(), others.variance.end());
        error.insert(error.end(), others.error.begin(), others.error.end());
    }
};

struct OwnRowOptions {
    double epsilon;  // what a surfel may be off by, the RMS over the test
    int check_rays;  // that are shot from each surfel, to tell
    int rays;        // of an own row
    std::size_t most;
};

// `coefs`: the coefficients of the test's values in the basis, whose functions `at_surfels` has. The shooter is of no
// team: processes of `team` ask batches of surfels each.
ContradictedSurfels find_contradicted(const std::vector<Place>& places, const std::vector<double>& areas,
                                      const RowShooter& shooter, const RowTest& test, const SparseRows& at_surfels,
                                      const std::vector<float>& coefs, const OwnRowOptions& options,
                                      const Progress& progress, const Team& team = {});

// Clusters of surfels near each other that receive alike, each with the one in its middle: halved until what they
// differ by is allowed, those first that differ most, as many as there may be (as transfer vectors are clustered by
// Sloan, Hall, Hart and Snyder 2003).
struct Cluster {
    std::uint32_t middle;                // index of a surfel
    std::vector<std::uint32_t> members;  // indices among ContradictedSurfels
};
std::vector<Cluster> cluster_alike(const Scene& scene, const std::vector<double>& areas,
                                   const ContradictedSurfels& contradicted, const RowTest& test,
                                   const OwnRowOptions& options, const Progress& progress);

// Is a row nearer to what rays say of a surfel, a member among contradicted ones, than the basis is?
bool is_better(const RowTest& test, const RowTest::Received& received, std::size_t row,
               const ContradictedSurfels& contradicted, std::size_t member, double area);

// Patches that are in one nook as a whole (BasisSight), of which the basis has the light at one point of one of them,
// which something may stand on: rays from all over a patch tell what it has on the mean. One cluster for each nook, and
// beyond these one for each of its patches, the widest of all first, as long as there are no more than `most`.
// `middle` is the member whose free area is largest; members are indices of surfels. `areas`: of each surfel what is
// not inside geometry.
std::vector<Cluster> patch_nooks(const BasisSight& sight, const SurfelPoints& points, const std::vector<double>& areas,
                                 std::size_t most);

// Makes own functions the only ones on surfels that have one: `own` of each, its column Receivers::none where it has
// none.
void give_own_functions(const std::vector<SparseRows::Entry>& own, SparseRows& at_surfels);

}  // namespace surflux
