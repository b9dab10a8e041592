#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/colors.h"

namespace surflux {

// What surfels reflect around the mirror direction, beside what they reflect in all: the specular reflectance and the
// exponent of its Phong lobe (GlossyLobe has what they mean). Most scenes have none, which takes no memory.
class Gloss {
public:
    static constexpr double usual_exponent = 20.0;

    Gloss() = default;
    // Of each surfel; either may be empty, for none and for the usual exponent.
    Gloss(Colors specular, std::vector<double> exponents);

    bool empty() const { return specular_.empty() && exponents_.empty(); }
    bool has_specular() const { return !specular_.empty(); }
    Rgb specular(std::size_t i) const { return specular_.empty() ? Rgb{} : specular_[i]; }
    double exponent(std::size_t i) const { return exponents_.empty() ? usual_exponent : exponents_[i]; }

    // Of the surfels at the indices, in that order.
    Gloss select(const std::vector<std::uint32_t>& indices) const;
    // That of `count` more surfels behind `own` ones.
    void append(const Gloss& other, std::size_t own, std::size_t count);

private:
    Colors specular_;
    std::vector<double> exponents_;
};

}  // namespace surflux
