#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "surflux/core/progress.h"

namespace surflux {

// Makes a vector larger, with reports in between: the first touch of its memory may take a second for each gigabyte.
// What is made with it has hardly begun.
template <class T>
void resize_with_reports(std::vector<T>& values, std::size_t size, const Progress& progress) {
    constexpr std::size_t at_once = std::max<std::size_t>(1, (std::size_t{1} << 24) / sizeof(T));
    values.reserve(size);
    while (values.size() < size) {
        values.resize(std::min(size, values.size() + at_once));
        if (values.size() < size) report(progress, 1, size);
    }
}

}  // namespace surflux
