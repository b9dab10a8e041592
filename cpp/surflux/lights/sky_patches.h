#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/lights.h"

namespace surflux {

// The sky dome in 145 patches of about the same solid angle (Tregenza 1987), or with each row of them in m rows of m
// times as many (Reinhart 2001): 144 m^2 + 1. Numbered as Radiance's gendaymtx has them: 0 is the ground, the whole
// lower half; then rows from the horizon up, each clockwise seen from above, its first patch centred on north (+y; +x
// is east, +z is up); last comes the cap at the zenith, half as high as a row.
class SkyPatches {
public:
    explicit SkyPatches(int subdivision);  // m: 1 to 8

    std::size_t size() const { return directions_.size(); }              // the ground included
    const std::vector<Vec3>& directions() const { return directions_; }  // of the middles
    const std::vector<double>& solid_angles() const { return solid_angles_; }
    // The patch that a direction, of any length but 0, lies in; the horizon itself is sky.
    std::size_t index_of(const Vec3& direction) const;
    // The direction at (u, v) of the unit square, which is mapped onto the patch in proportion to solid angle.
    Vec3 place_in(std::size_t patch, double u, double v) const;

    // From the horizon up, of a patch of the sky; the zenith's cap has one of its own.
    std::size_t row_of(std::size_t patch) const;

private:
    double height_;                   // of a row, in radians
    std::vector<std::size_t> first_;  // patch of each row, the zenith's last
    std::vector<Vec3> directions_;
    std::vector<double> solid_angles_;
};

// Mean radiance of an Environment in each patch: of images, over the pieces of pixels whose middles lie in it, no wider
// than 1/16 of a row. An even sky stays even to rounding, and the power of a sun of one pixel is kept to some 1 %.
std::vector<Rgb> patch_radiances(const Environment& environment, const SkyPatches& patches);

}  // namespace surflux
