#pragma once

#include <vector>

namespace surflux {

constexpr int max_resolution = 512;

// Where the curved method evaluates a disk: `resolution` directions around it, evenly, and along each the
// resolution / 2 points of Gauss and Legendre's rule between the centre and the end of the domain. What is integrated
// is smooth inside and ends in rims and creases: along a direction these are exact, and around the disk it is periodic.
struct PolarGrid {
    explicit PolarGrid(int resolution);

    int directions, rings;
    std::vector<float> cosine, sine;  // of each direction
    std::vector<float> radius;        // of each ring, as a fraction of the end of the domain
    std::vector<float> weight;        // of each ring: times the square of that end, the area that a point stands for
};

}  // namespace surflux
