#include "surflux/render/seen_tiles.h"

#include <algorithm>

#include "surflux/core/parallel.h"

namespace surflux {

SeenTiles::SeenTiles(const std::vector<float>& places, const std::vector<float>& normals, int width, int height)
    : columns_((width + side - 1) / side) {
    const int rows = (height + side - 1) / side;
    std::vector<std::vector<Surface>> tiles(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
    parallel_for(tiles.size(), 16, [&](std::size_t tile) {
        const int column = static_cast<int>(tile) % columns_, row = static_cast<int>(tile) / columns_;
        std::vector<Surface>& found = tiles[tile];
        for (int y = side * row; y < std::min(height, side * (row + 1)); ++y) {
            for (int x = side * column; x < std::min(width, side * (column + 1)); ++x) {
                const std::size_t pixel =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                const float *place = &places[4 * pixel], *normal = &normals[4 * pixel];
                if (place[3] < 0.0f) continue;
                auto at = std::find_if(found.begin(), found.end(),
                                       [&](const Surface& surface) { return surface.object == place[3]; });
                if (at == found.end()) {
                    Surface first{};
                    first.object = place[3];
                    for (int axis = 0; axis < 3; ++axis) {
                        first.low[axis] = first.high[axis] = place[axis];
                        first.normal_low[axis] = first.normal_high[axis] = normal[axis];
                    }
                    found.push_back(first);
                    continue;
                }
                for (int axis = 0; axis < 3; ++axis) {
                    at->low[axis] = std::min(at->low[axis], place[axis]);
                    at->high[axis] = std::max(at->high[axis], place[axis]);
                    at->normal_low[axis] = std::min(at->normal_low[axis], normal[axis]);
                    at->normal_high[axis] = std::max(at->normal_high[axis], normal[axis]);
                }
            }
        }
    });
    begin_.push_back(0);
    for (const std::vector<Surface>& tile : tiles) {
        surfaces_.insert(surfaces_.end(), tile.begin(), tile.end());
        begin_.push_back(static_cast<std::uint32_t>(surfaces_.size()));
    }
}

bool SeenTiles::meets(std::size_t tile, const float center[3], float radius, const float normal[3],
                      float object) const {
    for (std::uint32_t k = begin_[tile]; k < begin_[tile + 1]; ++k) {
        const Surface& surface = surfaces_[k];
        if (surface.object != object) continue;
        float squared = 0.0f, cosine = 0.0f;  // least and largest
        for (int axis = 0; axis < 3; ++axis) {
            const float d = std::clamp(center[axis], surface.low[axis], surface.high[axis]) - center[axis];
            squared += d * d;
            cosine += std::max(surface.normal_low[axis] * normal[axis], surface.normal_high[axis] * normal[axis]);
        }
        // Rounded as it may be, the shader's own test is no stricter than this one.
        return squared <= 1.0001f * radius * radius && cosine > -1e-5f;
    }
    return false;
}

SeenTiles::Rectangle SeenTiles::part(const Rectangle& within, const float center[3], float radius,
                                     const float normal[3], float object) const {
    if (within.empty()) return within;
    int left = within.right, top = within.bottom, right = within.left, bottom = within.top;
    for (int row = within.top / side; row <= (within.bottom - 1) / side; ++row) {
        for (int column = within.left / side; column <= (within.right - 1) / side; ++column) {
            const std::size_t tile =
                static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
            if (!meets(tile, center, radius, normal, object)) continue;
            left = std::min(left, side * column);
            right = std::max(right, side * (column + 1));
            top = std::min(top, side * row);
            bottom = std::max(bottom, side * (row + 1));
        }
    }
    return {std::max(left, within.left), std::max(top, within.top), std::min(right, within.right),
            std::min(bottom, within.bottom)};
}

}  // namespace surflux
