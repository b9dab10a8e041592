#include "surflux/scene/colors.h"

#include <cstring>

namespace surflux {

namespace {

constexpr std::size_t most = 256;

// Of bits: -0 and 0 are two, and NaN is itself.
bool same(const Rgb& a, const Rgb& b) { return std::memcmp(&a, &b, sizeof(Rgb)) == 0; }

}  // namespace

Colors::Colors(const std::vector<Rgb>& values) {
    reserve(values.size());
    for (const Rgb& value : values) push_back(value);
}

Colors::Colors(std::size_t count, const Rgb& value) : palette_{value}, index_(count, 0) {}

void Colors::reserve(std::size_t count) {
    if (each_.empty())
        index_.reserve(count);
    else
        each_.reserve(count);
}

void Colors::push_back(const Rgb& value) {
    if (!each_.empty()) {
        each_.push_back(value);
        return;
    }
    if (last_ >= palette_.size() || !same(palette_[last_], value)) {
        for (last_ = 0; last_ < palette_.size() && !same(palette_[last_], value);) ++last_;
        if (last_ == palette_.size()) {
            if (palette_.size() == most) {
                to_each();
                each_.push_back(value);
                return;
            }
            palette_.push_back(value);
        }
    }
    index_.push_back(static_cast<std::uint8_t>(last_));
}

void Colors::append(const Colors& other) {
    for (const Rgb& value : other) push_back(value);
}

void Colors::to_each() {
    each_.reserve(index_.capacity());
    for (const std::uint8_t k : index_) each_.push_back(palette_[k]);
    std::vector<Rgb>().swap(palette_);
    std::vector<std::uint8_t>().swap(index_);
}

}  // namespace surflux
