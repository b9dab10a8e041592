#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/residuals.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// One bounce of a solution, gathered anew. Surfaces nearer to the place than their size do not send one value: there,
// rays gather once more where they arrive.
class ResidualRays {
public:
    // Where the sequences of one place stand, which go on evenly from call to call.
    struct Sequences {
        Sequences(std::uint64_t seed, std::uint64_t stream);
        EvenPoints directions, lights;
        Random random;
        double next_choice();  // of a light, in [0, 1)

    private:
        double choice_;
    };

    // `irradiance`: H of `surfels`, those of the scene. `points`: of the shapes of places.
    ResidualRays(const Surfels& surfels, const Tracer& tracer, const LightSampler& lights,
                 const std::vector<Rgb>& irradiance, const Regions& regions, const SurfelPoints& points)
        : surfels_(surfels),
          tracer_(tracer),
          lights_(lights),
          irradiance_(irradiance),
          regions_(regions),
          points_(points) {}

    // Adds `count` rays over the hemisphere of a place and as many towards lights.
    void gather(const Place& place, int count, Sequences& sequences, Gathered& sum);

    std::size_t rays = 0;

private:
    struct Gain {
        Rgb irradiance;
        std::uint32_t target;
        bool is_of_lamp, is_first;  // of the first bounce, from the place itself
    };
    void aim(const Departure& from, const double* u, double choice, const Rgb& throughput, bool is_first);
    bool is_near(const Hit& hit) const;
    void send(const Hit& hit, const Rgb& throughput, Gathered& sum) const;

    const Surfels& surfels_;
    const Tracer& tracer_;
    const LightSampler& lights_;
    const std::vector<Rgb>& irradiance_;
    const Regions& regions_;
    const SurfelPoints& points_;
    std::vector<Ray> shadow_, towards_, ahead_;
    std::vector<Gain> shadow_gain_, towards_gain_;
    std::vector<Rgb> ahead_throughput_;
    std::vector<char> free_;
    std::vector<Hit> hits_;
};

}  // namespace surflux
