#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/meshless/meshless_field.h"

namespace surflux {

// What one level of a field adds at a place. With shares B_j of functions, values V_j that were gathered at their
// points, and what coarser levels say there, f(x_j), L07's eq. 9 is
//     f(x) + sum_j B_j (V_j - f(x_j)) = sum_j B_j V_j + (f(x) - sum_j B_j f(x_j)):
// the values, blended, and the slope of the coarser levels. Near walls a place sees other functions of f than points
// beside it: f jumps, and what is left of the jump is no slope. So the second term is limited, as gradients are in
// finite volumes (Barth and Jespersen 1989): to half of the standard deviation of the values around it, and a tenth of
// their mean, of the largest channel each. In rooms that lets nearly all of it pass; in fine relief it was what the
// field was off by.
class LevelLight {
public:
    // shares: of the functions that speak at the place. Those without a coefficient add nothing.
    LevelLight(const MeshlessField& field, const std::vector<BasisWeight>& shares)
        : largest_deviation_(field.largest_deviation), largest_part_(field.largest_part) {
        for (const BasisWeight& b : shares)
            if (field.gathered[b.function]) add(b.weight, field, b.function);
    }
    // Adds it to what coarser levels brought.
    void add_to(MeshlessField::At& light) const {
        if (!(share_ > 0.0)) return;
        const MeshlessField::At mean{values_.all / share_, values_.direct / share_};
        const double middle = largest_channel(mean.all);
        const double deviation = std::sqrt(std::max(0.0, squares_ / share_ - middle * middle));
        const double most = std::max(0.0, largest_deviation_ * deviation + largest_part_ * middle);
        light.all += share_ * (mean.all + limited(light.all + change_.all / share_ - mean.all, most) - light.all);
        light.direct +=
            share_ * (mean.direct + limited(light.direct + change_.direct / share_ - mean.direct, most) - light.direct);
    }

private:
    void add(double share, const MeshlessField& field, std::uint32_t function) {
        const MeshlessField::At& value = field.values[function];
        const double of_value = largest_channel(value.all);
        share_ += share;
        change_.all += share * field.coefficients[function];
        change_.direct += share * field.direct[function];
        values_.all += share * value.all;
        values_.direct += share * value.direct;
        squares_ += share * of_value * of_value;
    }
    static Rgb limited(const Rgb& slope, double most) {
        const double largest = std::max({std::abs(slope.x), std::abs(slope.y), std::abs(slope.z)});
        return largest > most ? (most / largest) * slope : slope;
    }

    double largest_deviation_, largest_part_;
    double share_ = 0.0, squares_ = 0.0;
    MeshlessField::At change_, values_;
};

}  // namespace surflux
