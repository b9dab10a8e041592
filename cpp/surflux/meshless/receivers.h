#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/progress.h"
#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/multilevel_basis.h"

namespace surflux {

// The active functions of a basis, at whose points irradiance is gathered, and the projection from these values to
// coefficients (L07 eq. 10). All others have coefficient 0.
class Receivers {
public:
    static constexpr std::uint32_t none = 0xffffffffu;

    Receivers(const MultilevelBasis& basis, const BasisSight& sight) : basis_(basis), sight_(sight) {}

    // To be called when the basis has got a level, or another one.
    void resize() {
        row_.resize(basis_.size(), none);
        parents_.resize(basis_.size());
    }

    // Makes functions receivers if they are not, and with them their parents: those on coarser levels that are not zero
    // at their points (L07 6.3), and in sight. Those that are new, ascending; rows are numbered as they come.
    std::vector<std::uint32_t> add(const std::vector<std::uint32_t>& functions, const Progress& progress);

    // Makes functions from `first` on receivers at the places of others: each shares the row of the original at its
    // point.
    void share_rows(std::uint32_t first, const std::vector<std::uint32_t>& originals, const Progress& progress);

    bool has(std::uint32_t function) const { return row_[function] != none; }
    std::uint32_t row(std::uint32_t function) const { return row_[function]; }

    // From values by row, for all functions: of any type that is added and scaled, `channels` interleaved of each.
    template <class Value>
    void coefficients(const std::vector<Value>& values, std::vector<Value>& out, std::size_t channels = 1) const {
        using Scale = std::conditional_t<std::is_floating_point_v<Value>, Value, double>;
        out.assign(basis_.size() * channels, Value{});
        for (std::size_t level = 0; level < basis_.levels(); ++level)
            parallel_for(basis_.first(level + 1) - basis_.first(level), 256, [&](std::size_t k) {
                const auto j = static_cast<std::uint32_t>(basis_.first(level) + k);
                if (!has(j)) return;
                Value* to = out.data() + j * channels;
                std::copy_n(values.data() + row_[j] * channels, channels, to);
                for (const BasisWeight& parent : parents_[j]) {
                    const Value* of_parent = out.data() + parent.function * channels;
                    const auto weight = static_cast<Scale>(parent.weight);
                    for (std::size_t c = 0; c < channels; ++c) to[c] -= weight * of_parent[c];
                }
            });
    }
    // The adjoint of that projection: a linear functional of coefficients as one of values, by row.
    std::vector<double> functional(std::vector<double> of_coefficients) const;
    // Calls visit(function, weight) for the parents of a function: their shares at its point.
    template <class Visit>
    void for_parents(std::uint32_t function, const Visit& visit) const {
        for (const BasisWeight& parent : parents_[function]) visit(parent.function, parent.weight);
    }

private:
    void find_parents(const std::vector<std::uint32_t>& functions, const Progress& progress);

    const MultilevelBasis& basis_;
    const BasisSight& sight_;
    std::vector<std::uint32_t> row_;                 // of each function
    std::vector<std::vector<BasisWeight>> parents_;  // of each function
    std::uint32_t rows_ = 0;
};

}  // namespace surflux
