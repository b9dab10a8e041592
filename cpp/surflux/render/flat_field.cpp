#include "surflux/render/flat_field.h"

#include <algorithm>
#include <optional>

#include "surflux/core/parallel.h"
#include "surflux/render/flat_image.h"

namespace surflux {

namespace {

constexpr std::size_t pixels_of_block = 4096;
constexpr double least_weight = 1e-7;

// The disks of a scene, as a picture of them alone blends them: where one is in front of all, it is among them, too.
struct Disks {
    std::vector<std::uint32_t> surfels;
    FlatImage image;

    Disks(const Scene& scene, std::vector<std::uint32_t> of, const Camera& camera, const PixelRays& rays, bool culling,
          gl::Api api)
        : surfels(std::move(of)) {
        SplatOptions options;
        options.culling = culling;
        for (const std::uint32_t i : surfels) options.objects.push_back(static_cast<std::int32_t>(scene.object[i]));
        image = flat_image(select(scene.surfels, surfels), {}, camera, rays.width, rays.height, options, api);
    }
};

std::optional<Disks> disks_of(const Scene& scene, const PixelPlaces& places, const Camera& camera, bool culling,
                              gl::Api api) {
    bool seen = false;
    for (std::size_t p = 0; p < places.size() && !seen; ++p)
        seen = places.is_seen(p) && places.triangle[p] == PixelPlaces::none;
    if (!seen) return std::nullopt;
    const std::vector<std::uint32_t> triangles = triangle_ranges(scene.surfels);
    std::vector<std::uint32_t> disks;
    for (std::uint32_t i = 0; i < scene.surfels.size(); ++i)
        if (triangles[i] == triangles[i + 1]) disks.push_back(i);
    return Disks(scene, std::move(disks), camera, places.rays, culling, api);
}

}  // namespace

void FlatField::at_nodes(const std::vector<Rgb>& values, std::vector<Value>& out) const {
    out.resize(nodes.rows());
    parallel_for(nodes.rows(), 1024, [&](std::size_t node) {
        Rgb sum;
        nodes.for_row(node, [&](std::uint32_t surfel, float w) { sum += static_cast<double>(w) * values[surfel]; });
        out[node] = {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z), 0.0f};
    });
}

FlatField flat_field(const Scene& scene, const PatchCorners& corners, const PixelPlaces& places, const Camera& camera,
                     bool culling, gl::Api api) {
    const std::optional<Disks> disks = disks_of(scene, places, camera, culling, api);
    // Nodes are numbered corners first, then surfels; in the end only those that are seen, in that order.
    const auto first_surfel = static_cast<std::uint32_t>(corners.means.rows());
    std::vector<SparseRows> parts((places.size() + pixels_of_block - 1) / pixels_of_block);
    parallel_blocks(places.size(), pixels_of_block, [&](std::size_t begin, std::size_t end) {
        SparseRows& rows = parts[begin / pixels_of_block];
        for (std::size_t p = begin; p < end; ++p) {
            const std::uint32_t t = places.triangle[p];
            if (t != PixelPlaces::none) {
                Vec3 w = corner_weights(scene.surfels.triangles[t], places.place(p));
                for (int k = 0; k < 3; ++k) w[k] = std::max(0.0, w[k]);
                const double sum = w.x + w.y + w.z;
                for (int k = 0; k < 3; ++k)
                    if (w[k] > least_weight)
                        rows.entries.push_back({corners.of_triangle[3 * t + static_cast<std::uint32_t>(k)],
                                                static_cast<float>(w[k] / sum)});
            } else if (places.is_seen(p)) {
                const std::size_t before = rows.entries.size();
                disks->image.for_pixel(p, [&](std::uint32_t k, float w) {
                    rows.entries.push_back({first_surfel + disks->surfels[k], w});
                });
                if (rows.entries.size() == before) rows.entries.push_back({first_surfel + places.surfel[p], 1.0f});
            }
            rows.end_row();
        }
    });
    FlatField out;
    for (const SparseRows& part : parts) out.pixels.append(part);
    std::vector<std::uint32_t> number(first_surfel + scene.surfels.size(), 0);
    for (const SparseRows::Entry& e : out.pixels.entries) number[e.column] = 1;
    std::uint32_t count = 0;
    for (std::uint32_t node = 0; node < number.size(); ++node) {
        if (number[node] == 0) continue;
        number[node] = count++;
        if (node < first_surfel)
            corners.means.for_row(node, [&](std::uint32_t i, float w) { out.nodes.entries.push_back({i, w}); });
        else
            out.nodes.entries.push_back({node - first_surfel, 1.0f});
        out.nodes.end_row();
    }
    parallel_for(out.pixels.entries.size(), 65536, [&](std::size_t e) {
        SparseRows::Entry& entry = out.pixels.entries[e];
        entry.column = number[entry.column];
    });
    return out;
}

}  // namespace surflux
