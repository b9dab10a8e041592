#pragma once

#include <memory>
#include <vector>

#include "surflux/radiosity/gathering.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

// Gathered light anywhere: the values of receivers, each continued linearly by the slope that its neighbours give and
// turned to the normal asked for (Franke and Nielson 1980, with the tilt of Ward and Heckbert 1992), blended by
// Shepard's weights.
class NodalField {
public:
    struct Slope {
        Rgb u, v;
    };
    // One of any number of fields over the same receivers.
    struct Values {
        std::vector<TiltedRgb> values;
        std::vector<Slope> slopes;
    };

    NodalField(std::vector<Place> receivers, std::vector<std::uint32_t> objects);

    std::size_t size() const { return receivers_.size(); }
    const Interpolation& interpolation() const { return *interpolation_; }
    Values fit(std::vector<TiltedRgb> values) const;
    Rgb at(const Values& field, const Vec3& point, const Vec3& normal,
           const std::vector<Interpolation::Weight>& weights) const;

private:
    Rgb turned(const TiltedRgb& value, std::uint32_t k, const Vec3& normal) const;

    std::vector<Place> receivers_;
    std::vector<std::uint32_t> objects_;
    std::vector<Vec3> positions_, normals_;
    std::vector<Frame> frames_;
    std::unique_ptr<Interpolation> interpolation_;
};

}  // namespace surflux
