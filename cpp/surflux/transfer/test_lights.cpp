#include "surflux/transfer/test_lights.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/transfer/group_light.h"

namespace surflux {

namespace {

constexpr std::size_t rays_of_lamp = 65536;

}  // namespace

TestLights::TestLights(const CompiledScene& compiled, const TransportOperator& of,
                       const std::vector<float>& reflectance, const std::vector<Vec3>& lamps, std::uint64_t seed,
                       const Progress& progress)
    : RowTest(lamps.size(), 1.0f), sent_(of.senders.size() * lamps.size(), 0.0f) {
    const GroupLight light(compiled, of.senders, of.samples);
    for (std::size_t lamp = 0; lamp < size(); ++lamp) {
        report(progress, lamp, size());
        const std::vector<float> direct =
            light.irradiance({PointLight{lamps[lamp], {1.0, 1.0, 1.0}}}, reflectance, {rays_of_lamp, seed});
        for (const std::uint32_t leaf : of.senders.leaves) {
            const Rgb reflected{static_cast<double>(reflectance[3 * leaf]),
                                static_cast<double>(reflectance[3 * leaf + 1]),
                                static_cast<double>(reflectance[3 * leaf + 2])};
            sent_[leaf * size() + lamp] = static_cast<float>(luminance(reflected)) * direct[3 * leaf];
        }
    }
    of.senders.pull_up(sent_, size());
}

void TestLights::find(const TransportOperator& of, std::size_t begin, std::size_t end, float* halves) const {
    for (std::size_t k = begin; k < end; ++k, halves += 2 * size()) add_reflected(of, k, sent_, halves);
}

}  // namespace surflux
