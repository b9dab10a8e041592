#pragma once

#include <vector>

#include "surflux/meshless/multilevel_basis.h"

// L07 eq. 9 and 10 straight from at_level(), with values of double or Rgb.
namespace surflux::shapes {

template <class Value>
Value evaluate(const MultilevelBasis& basis, const Vec3& point, const Vec3& normal, std::uint32_t object,
               const std::vector<Value>& coefficients, std::size_t levels = MultilevelBasis::all_levels) {
    Value value{};
    basis.for_functions(
        point, normal, object, [&](const BasisWeight& w) { value += w.weight * coefficients[w.function]; }, levels);
    return value;
}

// Functions for which `active` is 0 (none, where it is empty) have coefficient 0.
template <class Value>
std::vector<Value> project(const MultilevelBasis& basis, const std::vector<Value>& values,
                           const std::vector<char>& active = {}) {
    std::vector<Value> out(basis.size());
    for (std::uint32_t j = 0; j < basis.size(); ++j)
        if (active.empty() || active[j])
            out[j] = values[j] -
                     evaluate(basis, basis.position(j), basis.normal(j), basis.object(j), out, basis.level_of(j));
    return out;
}

}  // namespace surflux::shapes
