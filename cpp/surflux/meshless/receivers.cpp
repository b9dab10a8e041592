#include "surflux/meshless/receivers.h"

#include <algorithm>

#include "surflux/core/parallel.h"

namespace surflux {

std::vector<std::uint32_t> Receivers::add(const std::vector<std::uint32_t>& functions, const Progress& progress) {
    std::vector<std::uint32_t> fresh;
    std::vector<std::vector<BasisWeight>> parents;
    std::vector<std::uint32_t> asked = functions;
    while (!asked.empty()) {
        asked.erase(std::remove_if(asked.begin(), asked.end(), [&](std::uint32_t j) { return has(j); }), asked.end());
        std::sort(asked.begin(), asked.end());
        asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
        const std::size_t before = fresh.size();
        fresh.insert(fresh.end(), asked.begin(), asked.end());
        parents.resize(fresh.size());
        parallel_blocks(
            asked.size(), 64,
            [&](std::size_t begin, std::size_t end) {
                std::vector<BasisWeight> weights;
                for (std::size_t k = begin; k < end; ++k) {
                    const std::uint32_t j = asked[k];
                    std::vector<BasisWeight>& of = parents[before + k];
                    for (std::size_t level = 0; level < basis_.level_of(j); ++level) {
                        sight_.at_function(level, j, weights);
                        of.insert(of.end(), weights.begin(), weights.end());
                    }
                }
            },
            progress);
        asked.clear();
        for (std::size_t k = before; k < fresh.size(); ++k) row_[fresh[k]] = 0;  // none twice; numbered below
        for (std::size_t k = before; k < fresh.size(); ++k)
            for (const BasisWeight& parent : parents[k])
                if (!has(parent.function)) asked.push_back(parent.function);
    }
    std::vector<std::uint32_t> order(fresh.size());
    for (std::uint32_t k = 0; k < order.size(); ++k) order[k] = k;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return fresh[a] < fresh[b]; });
    for (const std::uint32_t k : order) {
        row_[fresh[k]] = static_cast<std::uint32_t>(functions_.size());
        functions_.push_back(fresh[k]);
        parents_.push_back(std::move(parents[k]));
    }
    std::sort(fresh.begin(), fresh.end());
    return fresh;
}

void Receivers::coefficients(const std::vector<Rgb>& values, std::vector<Rgb>& out) const {
    out.assign(basis_.size(), Rgb{});
    for (std::size_t level = 0; level < basis_.levels(); ++level)
        parallel_for(basis_.first(level + 1) - basis_.first(level), 256, [&](std::size_t k) {
            const auto j = static_cast<std::uint32_t>(basis_.first(level) + k);
            if (!has(j)) return;
            Rgb value = values[row_[j]];
            for (const BasisWeight& parent : parents_[row_[j]]) value -= parent.weight * out[parent.function];
            out[j] = value;
        });
}

std::vector<double> Receivers::functional(std::vector<double> of_coefficients) const {
    std::vector<double> out(functions_.size(), 0.0);
    for (std::size_t j = basis_.size(); j-- > 0;) {  // finer levels stand behind coarser ones
        if (!has(static_cast<std::uint32_t>(j))) continue;
        out[row_[j]] = of_coefficients[j];
        for (const BasisWeight& parent : parents_[row_[j]])
            of_coefficients[parent.function] -= parent.weight * of_coefficients[j];
    }
    return out;
}

}  // namespace surflux
