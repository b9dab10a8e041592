#include "surflux/meshless/receivers.h"

#include <algorithm>

#include "surflux/core/parallel.h"

namespace surflux {

void Receivers::find_parents(const std::vector<std::uint32_t>& functions, const Progress& progress) {
    parallel_blocks(
        functions.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<BasisWeight> weights;
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t j = functions[k];
                for (std::size_t level = 0; level < basis_.level_of(j); ++level) {
                    sight_.at_function(level, j, weights);
                    parents_[j].insert(parents_[j].end(), weights.begin(), weights.end());
                }
            }
        },
        progress);
}

std::vector<std::uint32_t> Receivers::add(const std::vector<std::uint32_t>& functions, const Progress& progress) {
    std::vector<std::uint32_t> fresh;
    std::vector<std::uint32_t> asked = functions;
    while (!asked.empty()) {
        asked.erase(std::remove_if(asked.begin(), asked.end(), [&](std::uint32_t j) { return has(j); }), asked.end());
        std::sort(asked.begin(), asked.end());
        asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
        find_parents(asked, progress);
        fresh.insert(fresh.end(), asked.begin(), asked.end());
        for (const std::uint32_t j : asked) row_[j] = 0;  // none twice; numbered below
        std::vector<std::uint32_t> parents;
        for (const std::uint32_t j : asked)
            for (const BasisWeight& parent : parents_[j])
                if (!has(parent.function)) parents.push_back(parent.function);
        asked = std::move(parents);
    }
    std::sort(fresh.begin(), fresh.end());
    for (const std::uint32_t j : fresh) row_[j] = rows_++;
    return fresh;
}

void Receivers::share_rows(std::uint32_t first, const std::vector<std::uint32_t>& originals, const Progress& progress) {
    std::vector<std::uint32_t> functions;
    for (const std::uint32_t original : originals) {
        functions.push_back(first++);
        row_[functions.back()] = row_[original];
    }
    find_parents(functions, progress);
}

std::vector<double> Receivers::functional(std::vector<double> of_coefficients) const {
    std::vector<double> out(rows_, 0.0);
    for (std::size_t j = basis_.size(); j-- > 0;) {  // finer levels stand behind coarser ones
        if (!has(static_cast<std::uint32_t>(j))) continue;
        out[row_[j]] += of_coefficients[j];
        for (const BasisWeight& parent : parents_[j])
            of_coefficients[parent.function] -= parent.weight * of_coefficients[j];
    }
    return out;
}

}  // namespace surflux
