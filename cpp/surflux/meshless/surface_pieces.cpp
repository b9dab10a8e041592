#include "surflux/meshless/surface_pieces.h"

#include <algorithm>

#include "surflux/core/error.h"

namespace surflux {

namespace {

// Digits below the leading one.
int digits_of(std::uint32_t path) {
    int digits = 0;
    while (path >>= 1) ++digits;
    return digits;
}

}  // namespace

SurfacePieces::SurfacePieces(const Scene& scene)
    : scene_(scene), triangles_(static_cast<std::uint32_t>(scene.surfels.triangles.size())) {
    const Surfels& s = scene.surfels;
    const std::vector<std::uint32_t> first = triangle_ranges(s);
    end_begin_ = end_ranges(s);
    for (std::uint32_t i = 0; i < s.size(); ++i)
        if (first[i] == first[i + 1]) disks_.push_back(i);
    require(s.triangles.size() + disks_.size() < 0xffffffffu, "scene: it has too many surfels to number");
    std::size_t objects = 0;
    for (std::uint32_t o : scene.object) objects = std::max<std::size_t>(objects, o + std::size_t{1});

    area_.assign(objects, 0.0);
    begin_.assign(objects + 1, 0);
    const auto each = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < triangles_; ++t)
            if (area(t) > 0.0) visit(t);
        for (std::uint32_t d = 0; d < disks_.size(); ++d)
            if (area(triangles_ + d) > 0.0) visit(triangles_ + d);
    };
    each([&](std::uint32_t piece) {
        const std::uint32_t object = scene.object[surfel_of(piece)];
        ++begin_[object + 1];
        area_[object] += area(piece);
    });
    for (std::size_t o = 0; o < objects; ++o) begin_[o + 1] += begin_[o];
    order_.resize(begin_[objects]);
    std::vector<std::size_t> to(begin_.begin(), begin_.end() - 1);
    each([&](std::uint32_t piece) { order_[to[scene.object[surfel_of(piece)]]++] = piece; });
}

std::uint32_t SurfacePieces::surfel_of(std::uint32_t piece) const {
    return is_disk(piece) ? disks_[piece - triangles_] : scene_.surfels.triangles[piece].surfel;
}

double SurfacePieces::area(std::uint32_t piece) const {
    const Surfels& s = scene_.surfels;
    if (!is_disk(piece)) return surflux::area_of(s.triangles[piece]);
    // The square in the disk, or less; an area may be missing, or lie to one side of where the disk ends.
    const std::uint32_t i = surfel_of(piece);
    const double square = 2.0 * s.radii[i] * s.radii[i];
    return s.areas.empty() || end_begin_[i] != end_begin_[i + 1] ? square : std::min(square, s.areas[i]);
}

Corners SurfacePieces::corners(std::uint32_t piece) const {
    if (is_disk(piece)) {
        const Vec3& center = scene_.surfels.positions[surfel_of(piece)];
        return {center, center, center};
    }
    const Triangle& t = scene_.surfels.triangles[piece];
    return {t.a, t.b, t.c};
}

const Corners& PartFinder::corners(std::uint32_t piece, std::uint32_t path) {
    const int digits = digits_of(path), before = digits_of(path_);
    int kept = 0;
    if (path_ == 0 || piece != piece_) {
        after_[0] = pieces_.corners(piece);
    } else {
        const int common = std::min(digits, before);
        kept = common - digits_of(((path >> (digits - common)) ^ (path_ >> (before - common))) << 1);
    }
    for (int k = kept; k < digits; ++k) {
        Corners halves[2];
        bisect(after_[k], halves[0], halves[1]);
        after_[k + 1] = halves[(path >> (digits - 1 - k)) & 1u];
    }
    piece_ = piece;
    path_ = path;
    return after_[digits];
}

}  // namespace surflux
