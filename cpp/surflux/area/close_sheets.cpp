#include "surflux/area/close_sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "surflux/area/effective_area.h"
#include "surflux/area/pieces.h"
#include "surflux/core/thread_scratch.h"

namespace surflux {

namespace {

constexpr double close_patches = 1e-4;  // of the size of the scene: half a millimetre in a room of 5 m

// Of coordinates, how far off what the user meant to be one place may be: a few roundings of doubles.
constexpr double one_place = 0x1p-48;

// How far a place is from a triangle that it lies over or under; infinite where it does not.
double distance(const Vec3& place, const Triangle& t) {
    const Vec3 corners[3] = {t.a - place, t.b - place, t.c - place};
    const Vec3 normal = cross_of(t);
    for (int k = 0; k < 3; ++k)
        if (dot(cross(corners[(k + 1) % 3] - corners[k], normal), corners[k]) < 0.0)
            return std::numeric_limits<double>::infinity();
    return std::abs(dot(normalized(normal), corners[0]));
}

}  // namespace

CloseSheetFinder::CloseSheetFinder(const Scene& scene, const Extent& extent)
    : scene_(scene), s_(scene.surfels), extent_(extent), triangles_(triangle_ranges(s_)) {
    std::vector<Vec3> centers;
    std::vector<double> radii;
    for (std::uint32_t i = 0; i < s_.size(); ++i) {
        if (!is_patch(i)) continue;
        patches_.push_back(i);
        centers.push_back(s_.positions[i]);
        radii.push_back(s_.radii[i]);
    }
    if (!patches_.empty()) index_ = std::make_unique<DiskIndex>(centers, radii);
}

void CloseSheetFinder::patches_near(std::uint32_t i, std::vector<std::uint32_t>& out) const {
    out.clear();
    if (!index_) return;
    thread_local std::vector<Neighbor> near;
    const ThreadScratch scratch(near);
    const double reach = is_patch(i) ? s_.radii[i] + std::max(close_patches * extent_.size, 2.0 * extent_.contact_of(i))
                                     : close_disk * s_.radii[i];
    index_->reaching(s_.positions[i], reach, near);
    for (const Neighbor& found : near)
        if (patches_[found.index] != i) out.push_back(patches_[found.index]);
    std::sort(out.begin(), out.end());
}

void CloseSheetFinder::find(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const {
    is_patch(i) ? patch(i, near, out) : disk(i, near, out);
}

// The nearest patch decides for which mesh.
void CloseSheetFinder::disk(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const {
    double nearest = close_disk * s_.radii[i];
    const std::uint32_t* found = nullptr;
    for (const std::uint32_t& k : near) {
        if (dot(s_.normals[i], s_.normals[k]) < alike_normals) continue;
        for (std::uint32_t t = triangles_[k]; t < triangles_[k + 1]; ++t)
            if (const double height = distance(s_.positions[i], s_.triangles[t]); height < nearest)
                nearest = height, found = &k;
    }
    if (found) out.push_back({i, scene_.object[*found], scene_.object[i], true, 0.0, nearest});
}

void CloseSheetFinder::patch(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const {
    const double low = 2.0 * extent_.contact_of(i), high = close_patches * extent_.size;
    std::vector<std::uint32_t> over;
    std::vector<double> heights;
    std::vector<Triangle> triangles;
    for (const std::uint32_t k : near) {
        if (dot(s_.normals[i], s_.normals[k]) < flat_normals) continue;
        const double height = dot(s_.normals[k], s_.positions[k] - s_.positions[i]);
        const double rise = length(cross(s_.normals[i], s_.normals[k])) * s_.radii[i];
        if (!(height + rise > low && height - rise < high)) continue;
        for (std::uint32_t t = triangles_[k]; t < triangles_[k + 1]; ++t) {
            triangles.push_back(s_.triangles[t]);
            triangles.back().surfel = static_cast<std::uint32_t>(over.size());
        }
        over.push_back(k);
        heights.push_back(std::abs(height));
    }
    if (over.empty()) return;
    const Triangle* all = s_.triangles.data();
    std::vector<double> taken(over.size(), 0.0);
    take_in_turn(pieces_of(all + triangles_[i], all + triangles_[i + 1], s_.positions[i]), triangles, s_.positions[i],
                 low, high, taken);
    for (std::size_t k = 0; k < over.size(); ++k)
        if (taken[k] > low * s_.radii[i])  // else of edges that touch
            out.push_back({i, scene_.object[i], scene_.object[over[k]], false, taken[k], heights[k]});
}

void CloseSheetFinder::find_facing(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Facing>& out,
                                   std::vector<Sheet>& sheets) const {
    const double wide = 2.0 * extent_.contact_of(i);
    // The origin of the coordinates may be far off the scene.
    const double least = one_place * (extent_.size + length(s_.positions[i]));
    for (const std::uint32_t k : near) {
        if (k < i || !is_patch(i) || dot(s_.normals[i], s_.normals[k]) > -flat_normals) continue;
        const double gap = dot(s_.normals[i], s_.positions[k] - s_.positions[i]);
        const double rise = length(cross(s_.normals[i], s_.normals[k])) * (s_.radii[i] + s_.radii[k]);
        if (!(gap + rise > -wide && gap - rise < wide)) continue;
        const Triangle* all = s_.triangles.data();
        const Pieces whole = pieces_of(all + triangles_[i], all + triangles_[i + 1], s_.positions[i]);
        const auto shared = [&](double low, double high) {
            Pieces rest = whole;
            for (std::uint32_t t = triangles_[k]; t < triangles_[k + 1] && !rest.empty(); ++t) {
                Triangle turned = s_.triangles[t];  // to face the patch's way, as pieces do
                std::swap(turned.b, turned.c);
                rest = without(rest, turned, s_.positions[i], low, high);
            }
            return area_of(whole) - area_of(rest);
        };
        const double least_area = wide * s_.radii[i];  // else of edges that touch
        if (const double area = shared(least, wide); area > least_area)
            out.push_back({scene_.object[i], scene_.object[k], area, gap});
        if (shared(-wide, wide) > least_area) sheets.push_back({i, k});
    }
}

std::vector<NarrowGap> CloseSheetFinder::gaps(const std::vector<std::vector<Facing>>& facing) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, NarrowGap> sums;
    for (const auto& some : facing)
        for (const Facing& at : some) {
            NarrowGap& sum = sums[{at.one, at.other}];
            sum.one = at.one, sum.other = at.other;
            sum.area += at.area;
            sum.width += at.area * at.width;
        }
    std::vector<NarrowGap> out;
    for (auto& [key, sum] : sums) {
        sum.width /= sum.area;
        out.push_back(sum);
    }
    return out;
}

// Effective areas: those of the scene may not be known yet.
void CloseSheetFinder::set_areas(std::vector<Meeting>& points, const Progress& progress) const {
    std::vector<std::uint32_t> surfels;
    for (const Meeting& at : points) surfels.push_back(at.surfel);
    AreaOptions options;
    options.backend = AreaBackend::cpu;
    const std::vector<double> areas = effective_areas(select(s_, surfels), options, progress);
    for (std::size_t k = 0; k < points.size(); ++k) points[k].area = areas[k];
}

std::vector<CloseSheet> CloseSheetFinder::sheets(const std::vector<std::vector<Meeting>>& meetings,
                                                 const Progress& progress) const {
    std::map<std::tuple<std::uint32_t, std::uint32_t, bool>, std::vector<Meeting>> sorted;
    for (const auto& some : meetings)
        for (const Meeting& at : some) sorted[{at.mesh, at.other, !at.is_point}].push_back(at);
    std::vector<double> of_mesh(s_.size() > 0 ? scene_.object.back() + 1 : 0, 0.0);
    for (const Triangle& t : s_.triangles) of_mesh[scene_.object[t.surfel]] += area_of(t);
    std::vector<CloseSheet> out;
    for (auto& [key, some] : sorted) {
        if (some.front().is_point) set_areas(some, progress);
        CloseSheet sheet;
        sheet.mesh = some.front().mesh, sheet.other = some.front().other;
        for (const Meeting& at : some) {
            sheet.points += at.is_point;
            sheet.area += at.area;
            sheet.height += at.area * at.height;
        }
        sheet.height /= sheet.area;
        sheet.share = sheet.area / of_mesh[sheet.mesh];
        out.push_back(sheet);
    }
    return out;
}

}  // namespace surflux
