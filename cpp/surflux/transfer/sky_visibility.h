#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/sample_points.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/row_test.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {

// What places see of a distant environment, by spherical harmonics in the scene's axes: 1 in directions in which
// nothing is, 0 elsewhere. Below the horizon of a place it goes on as its mirror image in the tangent plane. So it is 1
// all over where nothing occludes, exactly, and what is interpolated between places whose normals differ is occlusion
// alone; whoever uses it takes off what is below the horizon of the surface there.
class SkyVisibility {
public:
    SkyVisibility(const SurfelPoints& points, const Tracer& tracer, int order, std::uint64_t seed)
        : points_(points), tracer_(tracer), harmonics_(order), seed_(seed) {}

    std::size_t size() const { return harmonics_.size(); }

    struct Scratch {
        std::vector<Ray> rays;
        std::vector<char> free;
        std::vector<double> at, sums;
    };
    // Into values[0, size()), by so many rays, evenly over the hemisphere, and over the patch where the place is one.
    // `halves`: as far as the first and the second half of them say, 2 size(), or null.
    void find(const Place& place, int rays, Scratch& scratch, float* values, float* halves = nullptr) const;

private:
    const SurfelPoints& points_;
    const Tracer& tracer_;
    SphericalHarmonics harmonics_;
    std::uint64_t seed_;
};

// Rows of a transport operator that is to bring distant light to glossy surfaces differ where places see different
// parts of the sky: the mean square of the difference over the sphere. (L07 sec. 6.4 compares transfer matrices, which
// are "times visibility", by their norm ||.||_1; that of the noise of 512 rays comes near its threshold.)
class VisibilityTest : public RowTest {
public:
    static constexpr int order = 5;

    VisibilityTest(const SurfelPoints& points, const Tracer& tracer, std::uint64_t seed);

private:
    void find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const override;

    SkyVisibility visibility_;
};

}  // namespace surflux
