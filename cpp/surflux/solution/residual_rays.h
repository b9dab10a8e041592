#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/close_lamps.h"
#include "surflux/lights/light_rays.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/residuals.h"
#include "surflux/solution/tuning.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Monte Carlo estimate of D + T B at a place, one bounce T of a solution's radiosity B: cosine-distributed rays and
// next event estimation, combined by multiple importance sampling (LightSampler). A surface nearer to the place than
// its size is not taken to send one value: there a ray goes on for one more bounce.
class ResidualRays {
public:
    // Low-discrepancy sequences of one place, continued from call to call.
    struct Sequences {
        Sequences(std::uint64_t seed, std::uint64_t stream);
        EvenPoints directions, lights;
        Random random;
        double next_choice();  // of a light, in [0, 1)

    private:
        double choice_;
    };

    // `irradiance`: H of `surfels`, those of the scene. `lamps`: those of `lights`. `points`: of the shapes of places.
    ResidualRays(const Surfels& surfels, const Tracer& tracer, const LightSampler& lights, const CloseLamps& lamps,
                 const std::vector<Rgb>& irradiance, const Regions& regions, const SurfelPoints& points,
                 const SelfCheckTuning& tuning = {})
        : surfels_(surfels),
          tracer_(tracer),
          lights_(lights),
          lamps_(lamps),
          irradiance_(irradiance),
          regions_(regions),
          points_(points),
          near_widths_(tuning.near_widths) {}

    // Adds `count` rays over the hemisphere of a place and as many of next event estimation.
    void gather(const Place& place, int count, Sequences& sequences, Gathered& sum);

    std::size_t rays = 0;

private:
    struct Gain {
        Rgb irradiance;
        bool is_of_lamp, is_of_surfel;
        bool is_first;                   // of the first bounce, from the place itself
        std::uint32_t lamp = Hit::none;  // where it is known which, and `irradiance` is its kernel
    };
    // Of one lamp: sums of the kernels of samples that are lit, and of all, and of what they are expected to be.
    struct LampSums {
        double lit = 0.0, all = 0.0, expected = 0.0;
        int samples = 0;
    };
    // Which sources a place has by aim(): where a lamp is close, those that are no lamps.
    enum class Sources { all, no_lamps };
    void aim(const Departure& from, const double* u, double choice, const Rgb& throughput, bool is_first,
             Sources sources = Sources::all);
    void aim_at_lamps(const Receiver& receiver, const std::vector<LampSamples>& samples, const double* u, int round);
    bool is_near(const Hit& hit) const;
    void send(const Hit& hit, const Rgb& throughput, Gathered& sum) const;

    const Surfels& surfels_;
    const Tracer& tracer_;
    const LightSampler& lights_;
    const CloseLamps& lamps_;
    const std::vector<Rgb>& irradiance_;
    const Regions& regions_;
    const SurfelPoints& points_;
    double near_widths_;
    LightRays light_;
    std::vector<Gain> gain_;
    std::vector<LampSums> of_lamps_;
    std::vector<Ray> ahead_;
    std::vector<Rgb> ahead_throughput_;
    std::vector<Hit> hits_;
};

}  // namespace surflux
