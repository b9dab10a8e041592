#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// A colour for each of many surfels, exact, in a byte each where few are different: scenes have some materials, and a
// cloud often has one.
class Colors {
public:
    Colors() = default;
    Colors(const std::vector<Rgb>& values);  // NOLINT: an array of colours is what it is
    Colors(std::size_t count, const Rgb& value);

    std::size_t size() const { return each_.empty() ? index_.size() : each_.size(); }
    bool empty() const { return size() == 0; }
    const Rgb& operator[](std::size_t i) const { return each_.empty() ? palette_[index_[i]] : each_[i]; }

    void reserve(std::size_t count);
    void push_back(const Rgb& value);
    void append(const Colors& other);

    // The different ones; where they are many, all.
    const std::vector<Rgb>& palette() const { return each_.empty() ? palette_ : each_; }

    class Iterator {
    public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = Rgb;
        using difference_type = std::ptrdiff_t;
        using pointer = const Rgb*;
        using reference = const Rgb&;
        Iterator(const Colors& of, std::size_t at) : of_(&of), at_(at) {}
        const Rgb& operator*() const { return (*of_)[at_]; }
        Iterator& operator++() {
            ++at_;
            return *this;
        }
        bool operator==(const Iterator& other) const { return at_ == other.at_; }
        bool operator!=(const Iterator& other) const { return at_ != other.at_; }

    private:
        const Colors* of_;
        std::size_t at_;
    };
    Iterator begin() const { return {*this, 0}; }
    Iterator end() const { return {*this, size()}; }

private:
    void to_each();

    std::vector<Rgb> palette_;
    std::vector<std::uint8_t> index_;
    std::vector<Rgb> each_;  // where there are more colours than a byte can number
    std::size_t last_ = 0;   // of the palette, that was asked for
};

}  // namespace surflux
