#include "surflux/meshless/surface_pieces.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"

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
    require(s.triangles.size() + 2 * disks_.size() < 0xffffffffu, "scene: it has too many surfels to number");
    std::size_t objects = 0;
    for (std::uint32_t o : scene.object) objects = std::max<std::size_t>(objects, o + std::size_t{1});

    area_.assign(objects, 0.0);
    begin_.assign(objects + 1, 0);
    const auto each = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < triangles_; ++t)
            if (area(t) > 0.0) visit(t);
        for (std::uint32_t d = 0; d < disks_.size(); ++d)
            if (area(triangles_ + 2 * d) > 0.0) visit(triangles_ + 2 * d);
    };
    each([&](std::uint32_t piece) {
        const std::uint32_t object = scene.object[surfel_of(piece)];
        ++begin_[object + 1];
        area_[object] += (is_disk(piece) ? 2.0 : 1.0) * area(piece);
    });
    for (std::size_t o = 0; o < objects; ++o) begin_[o + 1] += begin_[o];
    order_.resize(begin_[objects]);
    std::vector<std::size_t> to(begin_.begin(), begin_.end() - 1);
    each([&](std::uint32_t piece) { order_[to[scene.object[surfel_of(piece)]]++] = piece; });
}

std::uint32_t SurfacePieces::surfel_of(std::uint32_t piece) const {
    return is_disk(piece) ? disks_[(piece - triangles_) / 2] : scene_.surfels.triangles[piece].surfel;
}

double SurfacePieces::half_diagonal(std::uint32_t surfel) const {
    const Surfels& s = scene_.surfels;
    // The area of a disk that ends before its rim is not in its middle: all of it, then, up to the end.
    if (s.areas.empty() || end_begin_[surfel] != end_begin_[surfel + 1]) return s.radii[surfel];
    return std::min(s.radii[surfel], std::sqrt(0.5 * s.areas[surfel]));
}

double SurfacePieces::area(std::uint32_t piece) const {
    if (!is_disk(piece)) return surflux::area_of(scene_.surfels.triangles[piece]);
    const double half = half_diagonal(surfel_of(piece));
    return half * half;
}

Corners SurfacePieces::corners(std::uint32_t piece) const {
    if (!is_disk(piece)) {
        const Triangle& t = scene_.surfels.triangles[piece];
        return {t.a, t.b, t.c};
    }
    const std::uint32_t i = surfel_of(piece);
    const Vec3& p = scene_.surfels.positions[i];
    const Frame frame = frame_around(scene_.surfels.normals[i]);
    const double half = half_diagonal(i);
    const Vec3 u = half * frame.u, v = half * frame.v;
    return (piece - triangles_) % 2 == 0 ? Corners{p - u, p - v, p + u} : Corners{p + u, p + v, p - u};
}

bool SurfacePieces::within_ends(std::uint32_t piece, const Vec3& position) const {
    const std::uint32_t i = surfel_of(piece);
    const Vec3 from_center = position - scene_.surfels.positions[i];
    for (std::uint32_t e = end_begin_[i]; e < end_begin_[i + 1]; ++e)
        if (dot(scene_.surfels.ends[e].normal, from_center) > scene_.surfels.ends[e].limit) return false;
    return true;
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
