#pragma once

#include <memory>
#include <vector>

#include "surflux/lights/emitter.h"

namespace surflux {

// A point of what is lit, and of a lamp, that is drawn for it.
struct LampSample {
    Vec3 at;
    Arrival arrival;        // its kernel, over all samples, has the mean that is asked for
    double expected = 0.0;  // the same mean, of less variance: unoccluded it is known better than by samples
};

// Samples of one lamp over one receiver.
class LampSamples {
public:
    LampSamples(const Emitter& lamp, const Light& light, const Receiver& receiver);
    // u: four numbers in [0, 1).
    LampSample sample(const double* u) const;
    bool is_close() const { return how_ != evenly; }

private:
    LampSample over_solid_angle(const double* u) const;
    LampSample from_area(const double* u) const;

    const Emitter& lamp_;
    const Receiver& receiver_;
    enum { evenly, by_solid_angle, by_light } how_ = evenly;
    Vec3 position_;  // of a light that is a point
    const AreaLight* area_ = nullptr;
    std::vector<Triangle> part_;  // of the receiver, what the lamp can shine on
    std::vector<double> up_to_;   // the solid angle of those triangles up to and with each
    double patch_ = 0.0, mean_ = 0.0;
};

// Lamps close to a patch, beside its size, light little of it: by the inverse square of the distance, of which points
// evenly over the patch hardly tell the mean. Theirs are drawn over the solid angle that it has as seen from the lamp,
// so that all bring the same, and their share that arrives is all that chance decides.
class CloseLamps {
public:
    explicit CloseLamps(const std::vector<Light>& lights) : lights_(lights), lamps_(emitters_of(lights)) {}
    // Is one close to it, or has it a narrow beam there?
    bool any(const Receiver& receiver) const;
    // Of all lamps, close or not.
    std::size_t size() const { return lamps_.size(); }
    const Emitter& operator[](std::size_t k) const { return *lamps_[k]; }
    LampSamples of(std::size_t k, const Receiver& receiver) const {
        return {*lamps_[k], lights_[lamps_[k]->index], receiver};
    }

private:
    const std::vector<Light>& lights_;
    std::vector<std::unique_ptr<Emitter>> lamps_;
};

}  // namespace surflux
