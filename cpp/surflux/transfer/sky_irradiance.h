#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/sky_patches.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/row_test.h"
#include "surflux/transfer/spherical_harmonics.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Irradiance at the receivers of a transport operator from each patch of the sky and from the ground, where radiance is
// 1: daylight coefficients of direct light (Tregenza and Waters 1983). What a patch would bring is integrated, and the
// share of it that arrives is found by rays into all of it, so that it is exact where a patch is free, or is not.
class SkyIrradiance {
public:
    SkyIrradiance() = default;
    SkyIrradiance(const TransportOperator& transport, const SurfelPoints& points, const Tracer& tracer,
                  const SkyPatches& patches, std::uint64_t seed, const Progress& progress, const Team& team = {});

    // By row, from radiances of patches: `channels` interleaved values each.
    void receive(const std::vector<float>& radiances, std::size_t channels, std::vector<float>& out) const;
    std::size_t bytes() const;
    // Throws ArgumentError unless it is of so many rows and patches.
    void require_whole(std::size_t rows, std::size_t patches) const;

    struct Entry {
        std::uint16_t patch, share;  // of the scale of the row
    };
    std::vector<std::uint64_t> begin{0};  // of each row, and the end
    std::vector<Entry> entries;
    std::vector<float> scale;
};

// Rows of a transport operator differ in what they receive of distant light, directly and by way of one reflection: of
// each of 25 spherical harmonics, a transfer vector (Sloan, Kautz and Snyder 2002), of as much power as natural light
// has in its band.
class SkyTest : public RowTest {
public:
    static constexpr int order = 5;

    // `reflectance`: by node of the senders, `colors` each.
    SkyTest(const SurfelPoints& points, const Tracer& tracer, const SenderGroups& senders, const SenderSamples& samples,
            const std::vector<float>& reflectance, std::uint64_t seed);

private:
    struct Scratch;
    static std::vector<float> amplitudes();
    void find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const override;
    // Adds what the halves of so many rays bring, each as an estimate.
    void add_direct(const Place& place, int rays, Scratch& scratch, float* halves) const;

    const SurfelPoints& points_;
    const Tracer& tracer_;
    SphericalHarmonics harmonics_{order};
    std::uint64_t seed_;
    std::vector<float> sent_;  // size() of each node of the senders
};

}  // namespace surflux
