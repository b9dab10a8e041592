#include "surflux/area/coincidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/area/joint_areas.h"
#include "surflux/area/pieces.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double least_share = 1e-9;

struct Covers {
    std::vector<Cover> covers;
    std::vector<double> uncovered;
    std::vector<CloseSheet> close_sheets;
    std::vector<NarrowGap> gaps;
    std::vector<Sheet> sheets;
};

class CoverFinder {
public:
    CoverFinder(const Scene& scene, const Extent& extent)
        : s_(scene.surfels), extent_(extent), triangles_(triangle_ranges(s_)), sheets_(scene, extent) {}

    Covers run(const Progress& progress) {
        Covers out;
        out.uncovered.assign(s_.size(), 1.0);
        if (s_.triangles.empty()) return out;
        constexpr std::size_t block = 256;
        const std::size_t blocks = (s_.size() + block - 1) / block;
        std::vector<std::vector<Cover>> covers(blocks);
        std::vector<std::vector<CloseSheetFinder::Meeting>> meetings(blocks);
        std::vector<std::vector<CloseSheetFinder::Facing>> facing(blocks);
        std::vector<std::vector<Sheet>> sheets(blocks);
        parallel_blocks(
            s_.size(), block,
            [&](std::size_t begin, std::size_t end) {
                std::vector<std::uint32_t> near;
                for (std::size_t k = begin; k < end; ++k) {
                    const auto i = static_cast<std::uint32_t>(k);
                    sheets_.patches_near(i, near);
                    sheets_.find(i, near, meetings[begin / block]);
                    sheets_.find_facing(i, near, facing[begin / block], sheets[begin / block]);
                    if (triangles_[i] != triangles_[i + 1]) cover(i, near, covers[begin / block], out.uncovered[i]);
                }
            },
            progress);
        for (const auto& some : covers) out.covers.insert(out.covers.end(), some.begin(), some.end());
        for (const auto& some : sheets) out.sheets.insert(out.sheets.end(), some.begin(), some.end());
        out.close_sheets = sheets_.sheets(meetings, progress);
        out.gaps = CloseSheetFinder::gaps(facing);
        return out;
    }

private:
    void cover(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Cover>& covers,
               double& uncovered) const {
        const double contact = 2.0 * extent_.contact_of(i);  // rays take surfaces so close for the patch's own
        std::vector<std::uint32_t> above;
        for (const std::uint32_t k : near) {
            if (k <= i || dot(s_.normals[i], s_.normals[k]) < flat_normals) continue;
            // How far a corner of either may rise over the other's plane by their tilt.
            const double rise = length(cross(s_.normals[i], s_.normals[k])) * (s_.radii[i] + s_.radii[k]);
            if (std::abs(dot(s_.normals[k], s_.positions[i] - s_.positions[k])) <= contact + rise) above.push_back(k);
        }
        if (above.empty()) return;
        const Triangle* all_triangles = s_.triangles.data();
        const Pieces whole =
            pieces_of(all_triangles + triangles_[i], all_triangles + triangles_[i + 1], s_.positions[i]);
        const double all = area_of(whole);
        std::vector<Triangle> over;
        for (std::uint32_t k : above) {
            Pieces rest = whole;
            for (std::uint32_t t = triangles_[k]; t < triangles_[k + 1] && !rest.empty(); ++t)
                rest = without(rest, s_.triangles[t], s_.positions[i], -contact, contact);
            // Edges that two patches share may overlap by as much as places are rounded.
            if (all - area_of(rest) <= contact * std::min(s_.radii[i], s_.radii[k])) continue;
            covers.push_back({i, k});
            for (std::uint32_t t = triangles_[k]; t < triangles_[k + 1]; ++t) {
                over.push_back(s_.triangles[t]);
                over.back().surfel = 0;
            }
        }
        if (over.empty()) return;
        std::vector<double> taken(1, 0.0);
        uncovered = std::min(1.0, take_in_turn(whole, over, s_.positions[i], -contact, contact, taken) / all);
    }

    const Surfels& s_;
    const Extent& extent_;
    std::vector<std::uint32_t> triangles_;
    CloseSheetFinder sheets_;
};

std::vector<Coarse> find_coarse(const Scene& scene, const Extent& extent) {
    std::vector<Coarse> out;
    for (std::uint32_t i = 0; i < scene.surfels.size(); ++i) {
        const double contact = 2.0 * extent.contact_of(i);
        if (!(contact > scene.surfels.radii[i])) continue;
        if (out.empty() || out.back().object != scene.object[i]) out.push_back({scene.object[i], 0, 0.0});
        ++out.back().surfels;
        out.back().contact = std::max(out.back().contact, contact);
    }
    return out;
}

// Borders of joined disks in place of those that they have in their objects; creases stay.
void take_borders(Surfels& s, const std::vector<char>& is_joined, const std::vector<DiskEnd>& borders) {
    const auto is_replaced = [&](const DiskEnd& end) { return end.kind == DiskEnd::border && is_joined[end.surfel]; };
    s.ends.erase(std::remove_if(s.ends.begin(), s.ends.end(), is_replaced), s.ends.end());
    s.ends.insert(s.ends.end(), borders.begin(), borders.end());
    std::stable_sort(s.ends.begin(), s.ends.end(),
                     [](const DiskEnd& a, const DiskEnd& b) { return a.surfel < b.surfel; });
}

}  // namespace

Coincidence find_coincidence(const Scene& scene, const Progress& progress) {
    const Extent extent(scene.surfels);
    Covers covers = CoverFinder(scene, extent).run(progress);
    return {std::move(covers.covers),       std::move(covers.uncovered),
            std::move(covers.close_sheets), std::move(covers.gaps),
            std::move(covers.sheets),       find_disk_overlaps(scene, extent, progress),
            find_coarse(scene, extent),     {}};
}

std::vector<std::uint32_t> count_once(Scene& scene, const Coincidence& found, const Progress& progress,
                                      const std::vector<char>& has_own_areas) {
    scene.covers = found.covers;
    scene.sheets = found.sheets;
    scene.spread = found.disks.spread;
    Surfels& s = scene.surfels;
    if (s.areas.empty()) return {};
    std::vector<double> share = found.uncovered;
    std::vector<std::uint32_t> kept;
    if (!found.disks.is_joined.empty()) {
        JointShares joint = take_joint_shares(scene, found.disks.is_joined, share, has_own_areas, progress);
        if (!s.ends.empty()) take_borders(s, found.disks.is_joined, joint.borders);
        kept = std::move(joint.kept);
    }
    for (std::size_t i = 0; i < s.size(); ++i)
        if (share[i] != 1.0) s.areas[i] *= std::max(share[i], least_share);
    return kept;
}

}  // namespace surflux
