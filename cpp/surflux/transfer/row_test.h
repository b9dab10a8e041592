#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "surflux/core/team.h"
#include "surflux/transfer/shot_rows.h"

namespace surflux {

// What tells the rows of a transport operator apart while it is built: some numbers of each. What they do not tell
// apart needs no finer receivers, whatever the light.
class RowTest {
public:
    virtual ~RowTest() = default;

    // By row, size() interleaved values, and the mean square of their standard error, from two halves of the rays.
    struct Received {
        std::vector<float> values;
        std::vector<float> variance;
    };
    // Appends the rows that are not there yet. A team pays where it takes rays.
    void receive(const ShotRows& of, Received& out, const Team& team = {}) const;
    // Makes each of the numbers count alike: an RMS of 1, where `weights` says how much of the surface rows stand for.
    void normalize(const Received& rows, const std::vector<double>& weights);
    // All of them by one factor, so that their RMS is `wanted`, the rows' values, too; with `only_up`, where it is
    // less.
    void normalize_together(Received& rows, const std::vector<double>& weights, double wanted, bool only_up);

    std::size_t size() const { return scale_.size(); }
    float scale(std::size_t c) const { return scale_[c]; }
    double mean_square(const float* values) const;
    // Does a row differ from what it is taken for by more than is allowed, beyond what the rays' variance may have
    // made? `allowed`: of the RMS of all or, where both are dim, of local_weight() times what is there.
    bool is_off(const float* values, const float* difference, double allowed, float variance) const;

protected:
    virtual double local_weight() const { return std::numeric_limits<double>::max(); }
    RowTest(std::size_t size, float scale) : scale_(size, scale) {}
    explicit RowTest(std::vector<float> scale) : scale_(std::move(scale)) {}
    // Adds what senders send along the links of a row, size() interleaved values of each node, to both halves.
    void add_reflected(const ShotRows& of, std::size_t row, const std::vector<float>& sent, float* halves) const;

private:
    // What the first and the second half of the rays tell of rows, 2 size() of each, each an estimate by itself.
    virtual void find(const ShotRows& of, std::size_t begin, std::size_t end, float* halves) const = 0;

    std::vector<float> scale_;
};

}  // namespace surflux
