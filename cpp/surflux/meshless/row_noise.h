#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

// What the rows of receivers are off by for want of rays, and which are to be shot anew for that. Of one row two halves
// say little, and nothing where neither met what is small and bright. So rows around that were made together with it
// are asked as well, in units of what each may be off by: beyond a wall light may be another.
class RowNoise {
public:
    explicit RowNoise(const HemisphereGather& gather) : gather_(gather) {}

    // Takes the gather's next rows: their places, objects and numbers of rays.
    void add(const std::vector<Place>& places, const std::vector<std::uint32_t>& objects,
             const std::vector<int>& counts, const Progress& progress);
    // Finds it for what surfels send, and for what each row may be off by.
    void find(const std::vector<Rgb>& sent, const std::vector<double>& allowed);
    // The standard error of each row, of a colour's norm.
    const std::vector<double>& standard_error() const { return standard_error_; }

    // Rows that are to be shot anew, with `most` rays at most: each once, whose error is more than is allowed. None
    // where `most` is less than a row that is aimed has.
    std::vector<HemisphereGather::Shot> wanted(const std::vector<double>& allowed, int most);
    // What these are to be aimed at: all that their rays and those of rows around met before.
    HemisphereGather::Aims aims(const std::vector<HemisphereGather::Shot>& rows, const std::vector<Rgb>& sent,
                                const Progress& progress) const;

private:
    struct Row {
        Place place;
        int count;  // of its rays, before it was aimed
        bool is_aimed = false;
        std::uint32_t neighbors = 0;  // itself among them
        std::array<std::uint32_t, Interpolation::most_sites> around{};
    };
    const HemisphereGather& gather_;
    std::vector<Row> rows_;
    std::vector<double> standard_error_;
};

}  // namespace surflux
