#include "surflux/trace/patch_votes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace surflux {

namespace {

constexpr std::size_t asked_of_each = 200;  // surfels of a patch, at most
constexpr double least_rays = 10.0;         // that reach the light from a patch: fewer say nothing
constexpr double least_light = 0.1;         // the same, of those from one side: less comes through gaps
constexpr double doubtful = 0.25;  // of the links to what is larger and turned otherwise: so many say the opposite
// Of a sheet: else all of it faces inwards, as a room that is furnished does, and nothing tells which it is.
constexpr double least_right = 0.05;
constexpr double nearly_all = 0.9;  // of an open sheet

enum class Verdict : std::uint8_t { unknown, right, turned };

// Surfels of a sheet that continue each other as they are given, and are on one side of it by its links, too: so that
// one link that errs does not make one patch of two.
struct Patch {
    std::uint32_t sheet = 0;
    std::vector<std::uint32_t> members;
    std::array<double, 2> leave{}, others{};  // rays from its fronts, and from behind
    double rays = 0.0;                        // from each side
    Verdict verdict = Verdict::unknown;
};

bool continues(const Surfels& s, std::uint32_t i, std::uint32_t j) {
    const double agree = agreement(s.normals[i], s.normals[j], s.positions[j] - s.positions[i]);
    return agree >= continuation && !mirror_decides(agree, dot(s.normals[i], s.normals[j]));
}

class Settling {
public:
    Settling(const Surfels& s, const SideRays& rays, const SheetOptions& options, SheetSides& sides)
        : s_(s), rays_(rays), options_(options), sides_(sides), patch_(s.size(), SheetSides::none) {
        for (OrientedSheet& sheet : sides_.sheets)
            sheet.settled =
                sheet.tangled > most_tangled && (sheet.kind != SheetKind::open || sheet.flat <= closing::most_flat);
        for (std::uint32_t i = 0; i < s_.size(); ++i)
            if (is_of_settled(i) && patch_[i] == SheetSides::none) gather_from(i);
    }

    void run() {
        if (patches_.empty()) return;
        for (const bool behind : {false, true}) look(behind);
        decide();
        doubt();
        close_open_ones();
        while (follow()) {
        }
        std::vector<std::size_t> right(sides_.sheets.size(), 0);
        for (const Patch& patch : patches_)
            if (patch.verdict == Verdict::right) right[patch.sheet] += patch.members.size();
        for (std::size_t k = 0; k < right.size(); ++k) {
            OrientedSheet& sheet = sides_.sheets[k];
            if (static_cast<double>(right[k]) < least_right * static_cast<double>(sheet.size)) sheet.settled = false;
            if (sheet.settled && sheet.kind == SheetKind::open) sheet.kind = SheetKind::body;
        }
        for (const Patch& patch : patches_) {
            if (!sides_.sheets[patch.sheet].settled) continue;
            const bool is_turned = patch.verdict == Verdict::turned;
            for (const std::uint32_t i : patch.members)
                sides_.against[i] = is_turned != sides_.sheets[patch.sheet].backwards;
        }
    }

private:
    bool is_of_settled(std::uint32_t i) const {
        return sides_.sheet[i] != SheetSides::none && sides_.sheets[sides_.sheet[i]].settled;
    }

    void gather_from(std::uint32_t seed) {
        const auto number = static_cast<std::uint32_t>(patches_.size());
        Patch patch;
        patch.sheet = sides_.sheet[seed];
        patch.members.push_back(seed);
        patch_[seed] = number;
        for (std::size_t k = 0; k < patch.members.size(); ++k) {
            const std::uint32_t i = patch.members[k];
            for (const std::uint32_t j : sides_.graph[i]) {
                if (patch_[j] != SheetSides::none || sides_.sheet[j] != patch.sheet) continue;
                if (sides_.against[j] != sides_.against[i] || !continues(s_, i, j)) continue;
                patch_[j] = number;
                patch.members.push_back(j);
            }
        }
        patches_.push_back(std::move(patch));
    }

    void look(bool behind) {
        std::vector<std::uint32_t> from;
        for (const Patch& patch : patches_) {
            const std::size_t size = patch.members.size(), count = std::min(size, asked_of_each);
            for (std::size_t k = 0; k < count; ++k) from.push_back(patch.members[k * size / count]);
        }
        const auto each = static_cast<std::size_t>(options_.rays);
        const std::vector<Met> met = rays_.cast(from, s_.normals, behind, options_.rays, options_.seed, {});
        for (std::size_t k = 0; k < met.size(); ++k) {
            Patch& patch = patches_[patch_[from[k / each]]];
            if (!behind) ++patch.rays;
            if (met[k].surfel == Hit::none)
                ++patch.leave[behind];
            else if (sides_.sheet[met[k].surfel] != patch.sheet && sides_.sheet[met[k].surfel] != SheetSides::none)
                ++patch.others[behind];
        }
    }

    // As Votes does of sheets: what is itself inside of another one is told by the rays that meet that.
    void decide() {
        std::vector<double> leave(sides_.sheets.size(), 0.0), all(sides_.sheets.size(), 0.0);
        for (const Patch& patch : patches_) {
            leave[patch.sheet] += patch.leave[0] + patch.leave[1];
            all[patch.sheet] += patch.rays;
        }
        for (Patch& patch : patches_) {
            const bool is_room = sides_.sheets[patch.sheet].kind == SheetKind::room;
            std::array<double, 2> light = patch.leave;
            if (leave[patch.sheet] < 2.0 * closing::dark * all[patch.sheet]) {
                if (is_room) continue;
                for (const std::size_t side : {0, 1}) light[side] += patch.others[side];
            }
            const double both = light[0] + light[1];
            if (both < std::max(least_rays, least_light * patch.rays)) continue;
            if (std::abs(light[0] - light[1]) <= closing::one_sided * both) continue;
            patch.verdict = (light[0] > light[1]) != is_room ? Verdict::right : Verdict::turned;
        }
    }

    // What continues, as it is given, larger patches that rays turn otherwise is not told by its own rays.
    void doubt() {
        std::vector<Patch*> doubted;
        for (Patch& patch : patches_) {
            if (patch.verdict == Verdict::unknown) continue;
            std::size_t same = 0, opposite = 0;
            for (const std::uint32_t i : patch.members)
                for (const std::uint32_t j : sides_.graph[i]) {
                    if (patch_[j] == SheetSides::none) continue;
                    const Patch& other = patches_[patch_[j]];
                    if (other.verdict == Verdict::unknown || other.verdict == patch.verdict) continue;
                    if (other.members.size() <= patch.members.size()) continue;
                    const double agree = agreement(s_.normals[i], s_.normals[j], s_.positions[j] - s_.positions[i]);
                    if (std::abs(agree) < continuation || mirror_decides(agree, dot(s_.normals[i], s_.normals[j])))
                        continue;
                    ++(agree > 0.0 ? same : opposite);
                }
            if (static_cast<double>(same) > doubtful * static_cast<double>(same + opposite)) doubted.push_back(&patch);
        }
        for (Patch* patch : doubted) patch->verdict = Verdict::unknown;
    }

    // Links that err may have turned large parts of a body against each other, so that it seems to be seen from both
    // sides: it closes where rays tell one side of nearly all of its patches.
    void close_open_ones() {
        std::vector<std::size_t> told(sides_.sheets.size(), 0);
        for (const Patch& patch : patches_)
            if (patch.verdict != Verdict::unknown) told[patch.sheet] += patch.members.size();
        for (std::size_t k = 0; k < told.size(); ++k) {
            OrientedSheet& sheet = sides_.sheets[k];
            if (!sheet.settled || sheet.kind != SheetKind::open) continue;
            sheet.settled = static_cast<double>(told[k]) >= nearly_all * static_cast<double>(sheet.size);
        }
    }

    // What no ray tells goes with what it continues. False: there is no more of it.
    bool follow() {
        std::vector<std::pair<Patch*, Verdict>> found;
        for (Patch& patch : patches_) {
            if (patch.verdict != Verdict::unknown) continue;
            std::array<std::size_t, 2> links{};
            for (const std::uint32_t i : patch.members)
                for (const std::uint32_t j : sides_.graph[i]) {
                    if (patch_[j] == SheetSides::none || patch_[j] == patch_[i]) continue;
                    const Verdict other = patches_[patch_[j]].verdict;
                    if (other != Verdict::unknown && continues(s_, i, j)) ++links[other == Verdict::turned];
                }
            if (links[0] + links[1] > 0)
                found.emplace_back(&patch, links[1] > links[0] ? Verdict::turned : Verdict::right);
        }
        for (const auto& [patch, verdict] : found) patch->verdict = verdict;
        return !found.empty();
    }

    const Surfels& s_;
    const SideRays& rays_;
    const SheetOptions& options_;
    SheetSides& sides_;
    std::vector<std::uint32_t> patch_;  // per surfel: index of its patch, or SheetSides::none
    std::vector<Patch> patches_;
};

}  // namespace

void settle_by_rays(const Surfels& surfels, const SideRays& rays, const SheetOptions& options, SheetSides& sides) {
    Settling(surfels, rays, options, sides).run();
}

}  // namespace surflux
