#pragma once

#include <cstddef>
#include <vector>

namespace surflux {

// A stretch of an array that somebody else keeps (C++20 has it in its library).
template <class T>
class Span {
public:
    Span(const T* begin, const T* end) : begin_(begin), end_(end) {}
    Span(const std::vector<T>& all) : Span(all.data(), all.data() + all.size()) {}
    const T* begin() const { return begin_; }
    const T* end() const { return end_; }
    std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
    bool empty() const { return begin_ == end_; }

private:
    const T *begin_, *end_;
};

}  // namespace surflux
