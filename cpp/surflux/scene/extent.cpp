#include "surflux/scene/extent.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/place_order.h"
#include "surflux/core/random.h"

namespace surflux {

namespace {

// A ray's origin and the corners of what it meets are each rounded by up to 2^-24 of their distance from the middle,
// the difference of the two, up to twice as long, is rounded again, and so are its products with the normal: 7 times
// as much in all. Of twice the distance this is 8 times.
constexpr double contact_share = 0x1p-22;

// Squares of areas and of distances, and their reciprocals, are ordinary numbers for all sizes between these, lengths
// floats.
constexpr double least_size = 1e-30, largest_size = 1e30;

// In units of the size: with triangles so far away, Embree's products of three coordinates are still floats.
constexpr double farthest = 1e10;

// Places of which the median stands for that of all.
constexpr std::size_t enough = 1 << 18;

template <class T>
T median(std::vector<T>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Surfels at different places: one at each of all, or, of a great many, at each of some drawn at random.
std::vector<std::uint32_t> distinct(const std::vector<Vec3>& positions) {
    std::vector<std::uint32_t> drawn(std::min(positions.size(), enough));
    Random random(0);
    for (std::size_t k = 0; k < drawn.size(); ++k)
        drawn[k] = static_cast<std::uint32_t>(drawn.size() < positions.size() ? random.below(positions.size()) : k);
    std::vector<Vec3> places;
    for (const std::uint32_t i : drawn) places.push_back(positions[i]);
    std::vector<std::uint32_t> out;
    const std::vector<std::uint32_t> order = place_order(places);
    for (std::size_t k = 0; k < order.size(); ++k)
        if (k == 0 || !(places[order[k]] == places[order[k - 1]])) out.push_back(drawn[order[k]]);
    return out;
}

}  // namespace

Extent::Extent(const Surfels& surfels) : reach(surfels.size()) {
    if (surfels.size() == 0) return;
    const std::vector<std::uint32_t> places = distinct(surfels.positions);
    std::vector<double> values(places.size());
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < places.size(); ++k) values[k] = surfels.positions[places[k]][axis];
        middle[axis] = median(values);
    }
    for (const Triangle& t : surfels.triangles)
        for (const Vec3* corner : {&t.a, &t.b, &t.c})
            reach[t.surfel] = std::max(reach[t.surfel], length(*corner - middle));
    for (std::size_t i = 0; i < surfels.size(); ++i)
        if (reach[i] == 0.0) reach[i] = length(surfels.positions[i] - middle) + surfels.radii[i];
    for (std::size_t k = 0; k < places.size(); ++k) values[k] = reach[places[k]];
    size = 2.0 * median(values);
    require(size >= least_size && size <= largest_size, "scene: it is ", size, " across, wanted between ", least_size,
            " and ", largest_size, "; choose other units");
    unit = std::ldexp(1.0, std::ilogb(size));
    for (std::size_t i = 0; i < surfels.size(); ++i)
        require(reach[i] <= farthest * size, "scene: surfel ", i, " reaches ", reach[i], " away from the others, ",
                farthest, " times as far as they: leave it out");
}

double Extent::contact(double distance) const { return contact_share * std::max(size, 2.0 * distance); }

}  // namespace surflux
