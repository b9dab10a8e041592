#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "surflux/core/progress.h"

namespace surflux {

// Makes a vector larger, with reports in between: the first touch of its memory may take a second for each gigabyte.
template <class T>
void resize_with_reports(std::vector<T>& values, std::size_t size, const Progress& progress) {
    constexpr std::size_t bytes_at_once = std::size_t{1} << 24;
    values.reserve(size);
    while (values.size() < size) {
        report(progress, 0, 1);
        values.resize(std::min(size, values.size() + bytes_at_once / sizeof(T)));
    }
}

}  // namespace surflux
