#include "surflux/render/patch_corners.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/place_order.h"
#include "surflux/scene/extent.h"
#include "surflux/solution/sight.h"

namespace surflux {

namespace {

constexpr double smooth = 0.9;        // cosine of normals over which patches make one surface, as a column's facets do
constexpr std::size_t grain = 1024;   // places of corners
constexpr double least_share = 1e-6;  // of a patch that light comes to, and in a mean: less has no say

class CornerMeans {
public:
    CornerMeans(const Scene& scene, const Tracer& tracer, const std::vector<double>& areas, const Progress& progress)
        : scene_(scene),
          surfels_(scene.surfels),
          sight_(tracer, scene),
          sites_(surfels_.positions, surfels_.normals),
          progress_(progress) {
        open_.assign(surfels_.size(), 0.0);
        for (const Triangle& t : surfels_.triangles) open_[t.surfel] += area_of(t);
        for (std::size_t i = 0; i < surfels_.size(); ++i)
            open_[i] = open_[i] > 0.0 ? std::min(1.0, areas[i] / open_[i]) : 0.0;
    }

    PatchCorners run() {
        const std::vector<std::uint32_t> order = ordered();
        std::vector<std::size_t> begin;  // of the corners at each place
        for (std::size_t k = 0; k < order.size(); ++k)
            if (k == 0 || !(corners_[order[k]] == corners_[order[k - 1]])) begin.push_back(k);
        begin.push_back(order.size());
        const std::size_t places = begin.size() - 1;
        PatchCorners out;
        out.of_triangle.resize(order.size());
        std::vector<SparseRows> parts((places + grain - 1) / grain);
        parallel_blocks(
            places, grain,
            [&](std::size_t from, std::size_t to) {
                std::vector<std::uint32_t> here;
                for (std::size_t place = from; place < to; ++place) {
                    here.assign(order.begin() + static_cast<std::ptrdiff_t>(begin[place]),
                                order.begin() + static_cast<std::ptrdiff_t>(begin[place + 1]));
                    add_means(here, parts[from / grain], out.of_triangle);
                }
            },
            progress_);
        for (std::size_t part = 0; part < parts.size(); ++part) {
            const auto first = static_cast<std::uint32_t>(out.means.rows());
            for (std::size_t k = begin[part * grain]; k < begin[std::min(places, (part + 1) * grain)]; ++k)
                out.of_triangle[order[k]] += first;
            out.means.append(parts[part]);
            parts[part] = {};
        }
        return out;
    }

private:
    // Corners that coincide stand together, up to the rounding of those that were computed one by one.
    std::vector<std::uint32_t> ordered() {
        const Extent extent(surfels_);
        corners_.resize(3 * surfels_.triangles.size());
        parallel_for(surfels_.triangles.size(), 4096, [&](std::size_t t) {
            const Triangle& triangle = surfels_.triangles[t];
            const Vec3* const of[3] = {&triangle.a, &triangle.b, &triangle.c};
            for (std::size_t k = 0; k < 3; ++k)
                for (int axis = 0; axis < 3; ++axis)
                    corners_[3 * t + k][axis] =
                        static_cast<float>(((*of[k])[axis] - extent.middle[axis]) / extent.unit);
        });
        return place_order(corners_, progress_);
    }

    // The rows of corners at one place: one for each surface that meets there.
    void add_means(const std::vector<std::uint32_t>& here, SparseRows& rows, std::vector<std::uint32_t>& row_of) const {
        thread_local std::vector<std::uint32_t> patches, surface;
        patches.clear();
        for (const std::uint32_t corner : here) patches.push_back(surfels_.triangles[corner / 3].surfel);
        std::sort(patches.begin(), patches.end());
        patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
        find_surfaces(patches, surface);
        const Triangle& triangle = surfels_.triangles[here[0] / 3];
        const Vec3& place = here[0] % 3 == 0 ? triangle.a : here[0] % 3 == 1 ? triangle.b : triangle.c;
        thread_local std::vector<std::uint32_t> row;  // of each surface, by its first patch
        row.assign(patches.size(), 0);
        for (std::size_t k = 0; k < patches.size(); ++k) {
            if (surface[k] != k) continue;
            row[k] = static_cast<std::uint32_t>(rows.rows());
            add_row(place, patches, surface, k, rows);
        }
        for (const std::uint32_t corner : here) {
            const auto found = std::lower_bound(patches.begin(), patches.end(), surfels_.triangles[corner / 3].surfel);
            row_of[corner] = row[surface[static_cast<std::size_t>(found - patches.begin())]];
        }
    }

    // Of each patch, the first of those that it makes one surface with.
    void find_surfaces(const std::vector<std::uint32_t>& patches, std::vector<std::uint32_t>& surface) const {
        surface.resize(patches.size());
        for (std::uint32_t k = 0; k < patches.size(); ++k) {
            surface[k] = k;
            for (std::uint32_t j = 0; j < k; ++j) {
                const std::uint32_t one = surface[j], other = surface[k];
                if (one == other || !make_one(patches[j], patches[k])) continue;
                for (std::uint32_t m = 0; m <= k; ++m)
                    if (surface[m] == std::max(one, other)) surface[m] = std::min(one, other);
            }
        }
    }

    bool make_one(std::uint32_t i, std::uint32_t j) const {
        return scene_.object[i] == scene_.object[j] && dot(surfels_.normals[i], surfels_.normals[j]) >= smooth &&
               sight_.joined(sites_.place(sight_, i), sites_.place(sight_, j));
    }

    void add_row(const Vec3& place, const std::vector<std::uint32_t>& patches,
                 const std::vector<std::uint32_t>& surface, std::size_t which, SparseRows& rows) const {
        double open = 0.0, sum = 0.0;
        for (std::size_t k = 0; k < patches.size(); ++k)
            if (surface[k] == which) open += open_[patches[k]];
        const auto weight = [&](std::size_t k) {
            const double share = open > least_share ? open_[patches[k]] : 1.0;
            // A patch of no size to speak of may have its middle at the corner.
            const double away = length(place - surfels_.positions[patches[k]]);
            return surface[k] == which ? share / std::max(away, least_share * surfels_.radii[patches[k]]) : 0.0;
        };
        for (std::size_t k = 0; k < patches.size(); ++k) sum += weight(k);
        for (std::size_t k = 0; k < patches.size(); ++k)
            if (weight(k) > least_share * sum)
                rows.entries.push_back({patches[k], static_cast<float>(weight(k) / sum)});
        rows.end_row();
    }

    const Scene& scene_;
    const Surfels& surfels_;
    const Sight sight_;
    const Sight::Sites sites_;
    const Progress& progress_;
    std::vector<Vec3> corners_;
    std::vector<double> open_;  // share of each patch that light comes to
};

}  // namespace

PatchCorners patch_corners(const Scene& scene, const Tracer& tracer, const std::vector<double>& areas,
                           const Progress& progress) {
    return CornerMeans(scene, tracer, areas, progress).run();
}

}  // namespace surflux
