#include "surflux/scene/gloss.h"

#include <algorithm>
#include <utility>

namespace surflux {

Gloss::Gloss(Colors specular, std::vector<double> exponents)
    : specular_(std::move(specular)), exponents_(std::move(exponents)) {
    const std::vector<Rgb>& found = specular_.palette();
    if (std::all_of(found.begin(), found.end(), [](const Rgb& c) { return c == Rgb{}; })) specular_ = {};
    if (std::all_of(exponents_.begin(), exponents_.end(), [](double e) { return e == usual_exponent; }))
        exponents_ = std::vector<double>();
}

Gloss Gloss::select(const std::vector<std::uint32_t>& indices) const {
    Colors specular;
    std::vector<double> exponents;
    if (!specular_.empty()) {
        specular.reserve(indices.size());
        for (const std::uint32_t i : indices) specular.push_back(specular_[i]);
    }
    if (!exponents_.empty()) {
        exponents.reserve(indices.size());
        for (const std::uint32_t i : indices) exponents.push_back(exponents_[i]);
    }
    return {std::move(specular), std::move(exponents)};
}

void Gloss::append(const Gloss& other, std::size_t own, std::size_t count) {
    if (!specular_.empty() || !other.specular_.empty()) {
        if (specular_.empty()) specular_ = Colors(own, {});
        specular_.append(other.specular_.empty() ? Colors(count, {}) : other.specular_);
    }
    if (!exponents_.empty() || !other.exponents_.empty()) {
        exponents_.resize(own, usual_exponent);
        exponents_.insert(exponents_.end(), other.exponents_.begin(), other.exponents_.end());
        exponents_.resize(own + count, usual_exponent);
    }
}

}  // namespace surflux
