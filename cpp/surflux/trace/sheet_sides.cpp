#include "surflux/trace/sheet_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/contacts.h"
#include "surflux/trace/joined_patches.h"
#include "surflux/trace/patch_votes.h"
#include "surflux/trace/side_changes.h"
#include "surflux/trace/side_rays.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t links = 12;        // neighbours that may continue a surfel
constexpr std::size_t witnesses = 2000;  // at most, of a sheet
constexpr double furnished = 0.02;       // of the rays: so many meet bodies inside of a room
constexpr double few_meet = 0.002;       // of the rays: so many that meet bodies from an open sheet are none
constexpr double no_crease = 0.8;        // cosine; at a crease, two leaves touch as the sides of a box do
constexpr double few_against = 0.05;  // what is tangled, but faces the same way nearly everywhere, has two sides, too
constexpr double doubtful = 0.25;     // of the links across the border of a patch: more, and it is none
constexpr double one_side = 0.5;      // cosine of an angle: on which side of a border both lie
// Of the links across, so many lead to one side: .25 to .41 of a contact of random points, .48 to .9 of a border.
constexpr double least_beside = 0.45;
constexpr double least_border = 12.0;  // links, and the root of its surfels: fewer are a contact, as of two leaves
constexpr std::size_t looks = 256;     // of a witness, all around
constexpr double around = 0.5;         // of these meet the inside of what closes around it

// Surfels at the same place are no neighbours, but have the same ones. Returns the spacing.
std::vector<double> surround(const Surfels& s, SheetSides& out, const Progress& progress) {
    const std::vector<Vec3>& positions = s.positions;
    const Progress asked = standing_at(0, positions.size(), progress);
    const auto [places, of_surfel] = distinct_places(positions, asked);
    std::vector<std::uint32_t> first(places.size());
    for (std::size_t i = positions.size(); i-- > 0;) first[of_surfel[i]] = static_cast<std::uint32_t>(i);
    const PointIndex index(places, asked);
    std::vector<double> spacing(positions.size());
    out.graph.resize(positions.size());
    out.two_sided.assign(positions.size(), false);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::uint32_t other = first[of_surfel[i]];
        if (dot(s.normals[i], s.normals[other]) < 0.0) out.two_sided[i] = out.two_sided[other] = true;
    }
    parallel_blocks(
        positions.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(positions[i], links + 1, near);
                spacing[i] = near[std::min<std::size_t>(5, near.size() - 1)].distance;
                for (const Neighbor& n : near)
                    if (n.index != of_surfel[i]) out.graph[i].push_back(first[n.index]);
            }
        },
        progress);
    return spacing;
}

// Takes out links between patches of pieces of meshes that do not hang together: a ball that rests on a floor touches
// it, and does not go on as the floor. Small pieces may be faces without common corners, and keep theirs.
void part_pieces(const Surfels& s, std::size_t smallest, NeighborGraph& graph) {
    if (s.triangles.empty()) return;
    const std::vector<std::uint32_t> piece = joined_patches(s, graph);
    std::vector<std::size_t> size(s.size(), 0);
    for (const std::uint32_t of : piece) ++size[of];
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (size[piece[i]] < smallest) continue;
        const auto is_apart = [&](std::uint32_t j) { return piece[j] != piece[i] && size[piece[j]] >= smallest; };
        graph[i].erase(std::remove_if(graph[i].begin(), graph[i].end(), is_apart), graph[i].end());
    }
}

// Where the rays of one side of a sheet went, as shares of them. Sides: 0 in front, 1 behind.
struct Side {
    double leave = 0.0, others = 0.0;
    double seen() const { return leave + others; }
};
using Sides = std::array<Side, 2>;

double margin_of(double a, double b) { return a + b > 0.0 ? (a - b) / (a + b) : 0.0; }

class Votes {
public:
    Votes(const Surfels& s, SheetSides& out, const std::vector<Vec3>& front, const SideRays& rays,
          const SheetOptions& options)
        : s_(s), out_(out), front_(front), rays_(rays), options_(options), sides_(out.sheets.size()) {}

    void ask(const std::vector<std::vector<std::uint32_t>>& members, const Progress& progress) {
        for (const std::vector<std::uint32_t>& m : members) {
            const std::size_t count = std::min(m.size(), witnesses);
            for (std::size_t k = 0; k < count; ++k) asked_.push_back(m[k * m.size() / count]);
        }
        for (const bool behind : {false, true}) {
            const std::size_t before = behind ? asked_.size() : 0;
            Progress half;
            if (progress)
                half = [&progress, before](std::size_t done, std::size_t total) {
                    return progress(before + done, 2 * total);
                };
            met_[behind] = rays_.cast(asked_, front_, behind, options_.rays, options_.seed, half);
            count(behind);
        }
        for (std::size_t k = 0; k < sides_.size(); ++k) decide_by_light(k);
        count_bodies();
        hear_witnesses();
        for (std::size_t k = 0; k < sides_.size(); ++k) find_room(k);
        face_bodies();
    }

private:
    double weight(std::uint32_t sheet) const {
        return 1.0 / static_cast<double>(options_.rays) /
               static_cast<double>(std::min(out_.sheets[sheet].size, witnesses));
    }

    template <class Body>  // (sheet, what was met)
    void each(bool behind, const Body& body) {
        const auto rays = static_cast<std::size_t>(options_.rays);
        for (std::size_t k = 0; k < met_[behind].size(); ++k) body(out_.sheet[asked_[k / rays]], met_[behind][k]);
    }

    void count(bool behind) {
        each(behind, [&](std::uint32_t sheet, const Met& met) {
            Side& side = sides_[sheet][behind];
            if (met.surfel == Hit::none)
                side.leave += weight(sheet);
            else if (out_.sheet[met.surfel] != sheet && out_.sheet[met.surfel] != SheetSides::none)
                side.others += weight(sheet);
        });
    }

    void decide_by_light(std::size_t k) {
        const auto& [front, behind] = sides_[k];
        OrientedSheet& sheet = out_.sheets[k];
        const bool is_dark = front.leave + behind.leave < 2.0 * closing::dark;
        sheet.margin = is_dark ? margin_of(front.seen(), behind.seen()) : margin_of(front.leave, behind.leave);
        if (std::abs(sheet.margin) <= closing::one_sided || sheet.flat > closing::most_flat) return;
        sheet.kind = SheetKind::body;
        sheet.backwards = sheet.margin < 0.0;
    }

    // Rays from the inside of what is taken for a body that meet the outside of other bodies.
    void count_bodies() {
        bodies_.assign(sides_.size(), 0.0);
        for (const bool behind : {false, true})
            each(behind, [&](std::uint32_t sheet, const Met& met) {
                if (met.surfel == Hit::none || out_.sheets[sheet].kind != SheetKind::body) return;
                const std::uint32_t other = out_.sheet[met.surfel];
                if (other == sheet || other == SheetSides::none) return;
                if (behind == out_.sheets[sheet].backwards || out_.sheets[other].kind != SheetKind::body) return;
                if (met.front != out_.sheets[other].backwards) bodies_[sheet] += weight(sheet);
            });
    }

    // How much of what a witness sees is the inside of one body.
    void hear_witnesses() {
        witnessed_.assign(sides_.size(), 0.0);
        if (options_.witnesses.empty()) return;
        for (const Vec3& at : options_.witnesses) {
            std::vector<double> inside(sides_.size(), 0.0);
            EvenPoints even(2, options_.seed, 0);
            for (std::size_t r = 0; r < looks; ++r) {
                const double* u = even.next();
                const double z = 2.0 * u[0] - 1.0, across = std::sqrt(1.0 - z * z), phi = 2.0 * pi * u[1];
                const Vec3 d{across * std::cos(phi), across * std::sin(phi), z};
                const Hit hit = rays_.tracer().closest({{at, d, Hit::none}, d});
                if (!hit || out_.sheet[hit.surfel] == SheetSides::none) continue;
                const OrientedSheet& sheet = out_.sheets[out_.sheet[hit.surfel]];
                const bool met_front = dot(front_[hit.surfel], d) < 0.0;
                if (sheet.kind == SheetKind::body && met_front == sheet.backwards)
                    inside[out_.sheet[hit.surfel]] += 1.0 / static_cast<double>(looks);
            }
            for (std::size_t k = 0; k < inside.size(); ++k) witnessed_[k] = std::max(witnessed_[k], inside[k]);
        }
    }

    void find_room(std::size_t k) {
        OrientedSheet& sheet = out_.sheets[k];
        const auto& [front, behind] = sides_[k];
        if (sheet.kind != SheetKind::body) return;
        const bool is_furnished = front.leave + behind.leave >= 2.0 * closing::dark && bodies_[k] >= furnished;
        if (!is_furnished && witnessed_[k] < around) return;
        sheet.kind = SheetKind::room;
        sheet.backwards = !sheet.backwards;
    }

    // Of which side of an open sheet bodies are seen: it is in the air, as they are.
    void face_bodies() {
        std::vector<std::array<double, 2>> meets(sides_.size());
        for (const bool behind : {false, true})
            each(behind, [&](std::uint32_t sheet, const Met& met) {
                if (met.surfel == Hit::none || out_.sheet[met.surfel] == SheetSides::none) return;
                const OrientedSheet& other = out_.sheets[out_.sheet[met.surfel]];
                if (out_.sheet[met.surfel] == sheet || other.kind == SheetKind::open) return;
                if (met.front != other.backwards) meets[sheet][behind] += weight(sheet);
            });
        for (std::size_t k = 0; k < sides_.size(); ++k)
            if (meets[k][0] + meets[k][1] > few_meet) out_.sheets[k].bodies = margin_of(meets[k][0], meets[k][1]);
    }

    const Surfels& s_;
    SheetSides& out_;
    const std::vector<Vec3>& front_;  // normals, alike in each sheet, and as most of its surfels have them
    const SideRays& rays_;
    const SheetOptions& options_;
    std::vector<Sides> sides_;
    std::vector<std::uint32_t> asked_;
    std::array<std::vector<Met>, 2> met_;
    std::vector<double> bodies_, witnessed_;
};

// Share of the links in a sheet that contradict the sides it has been given.
double tangled(const Surfels& s, const NeighborGraph& graph, const std::vector<std::uint32_t>& members,
               const std::vector<Vec3>& front) {
    std::size_t all = 0, bad = 0;
    for (std::uint32_t i : members)
        for (std::uint32_t j : graph[i]) {
            const double agree = agreement(front[i], front[j], s.positions[j] - s.positions[i]);
            if (std::abs(agree) < continuation || mirror_decides(agree, dot(front[i], front[j]))) continue;
            ++all;
            bad += agree < 0.0;
        }
    return all == 0 ? 0.0 : static_cast<double>(bad) / static_cast<double>(all);
}

double flatness(const std::vector<double>& spacing, const std::vector<std::uint32_t>& members,
                const std::vector<Vec3>& front) {
    Vec3 sum;
    double area = 0.0;
    for (std::uint32_t i : members) {
        const double a = spacing[i] * spacing[i];
        sum += a * front[i];
        area += a;
    }
    return area > 0.0 ? length(sum) / area : 1.0;
}

// What most of the links across its border say is a patch of surfels against their sheet; what some say and some do not
// is none: the one link by which a spanning tree reached it erred.
// Nor is what lies in front of its sheet, as the lowest points of a ball that rests on a floor do: the others lie all
// around them, and not on one side as across a border.
void drop_doubtful(const Surfels& s, SheetSides& out) {
    const auto along = [&](std::uint32_t i, std::uint32_t j) {
        const Vec3 d = s.positions[j] - s.positions[i];
        return d - dot(d, s.normals[i]) * s.normals[i];
    };
    for (const std::vector<std::uint32_t>& patch : patches_of(s, out.graph, out.against)) {
        if (out.sheets[out.sheet[patch.front()]].settled) continue;
        const bool is_open = out.sheets[out.sheet[patch.front()]].kind == SheetKind::open;
        std::size_t same = 0, opposite = 0, smooth = 0, beside = 0;
        for (std::uint32_t i : patch) {
            std::size_t before = smooth;
            Vec3 to_patch, to_others;
            for (std::uint32_t j : out.graph[i]) {
                if (out.against[j] || out.two_sided[j]) {
                    if (dot(s.normals[i], s.normals[j]) > no_crease) to_patch += along(i, j);
                    continue;
                }
                const double agree = agreement(s.normals[i], s.normals[j], s.positions[j] - s.positions[i]);
                const double cosine = dot(s.normals[i], s.normals[j]);
                if (std::abs(agree) < continuation || mirror_decides(agree, cosine)) continue;
                ++(agree > 0.0 ? same : opposite);
                if (!(agree < 0.0 && cosine < -no_crease)) continue;
                ++smooth;
                to_others += along(i, j);
            }
            if (dot(to_patch, to_others) < -one_side * length(to_patch) * length(to_others)) beside += smooth - before;
        }
        const double border = std::max(least_border, std::sqrt(static_cast<double>(patch.size())));
        if (static_cast<double>(is_open ? smooth : opposite) < border ||
            static_cast<double>(beside) < least_beside * static_cast<double>(smooth) ||
            (is_open && 2 * smooth < opposite) ||
            static_cast<double>(same) > doubtful * static_cast<double>(same + opposite))
            for (std::uint32_t i : patch) out.against[i] = false;
    }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> patches_of(const Surfels& s, const NeighborGraph& graph,
                                                   const std::vector<bool>& some) {
    std::vector<std::vector<std::uint32_t>> out;
    std::vector<bool> reached(s.size(), false);
    for (std::uint32_t seed = 0; seed < s.size(); ++seed) {
        if (reached[seed] || !some[seed]) continue;
        std::vector<std::uint32_t> members{seed};
        reached[seed] = true;
        for (std::size_t k = 0; k < members.size(); ++k) {
            const std::uint32_t i = members[k];
            for (std::uint32_t j : graph[i]) {
                if (reached[j] || !some[j]) continue;
                if (agreement(s.normals[i], s.normals[j], s.positions[j] - s.positions[i]) < continuation) continue;
                reached[j] = true;
                members.push_back(j);
            }
        }
        out.push_back(std::move(members));
    }
    return out;
}

bool SheetSides::turned(std::size_t surfel) const {
    if (sheet[surfel] == none || two_sided[surfel]) return false;
    const OrientedSheet& of = sheets[sheet[surfel]];
    if (of.tangled <= most_tangled || of.settled) return against[surfel] != of.backwards;
    return of.backwards && !against[surfel] && of.against <= few_against;
}

SheetSides sheet_sides(const Surfels& s, const SheetOptions& options, const Progress& progress) {
    SheetSides out;
    out.sheet.assign(s.size(), SheetSides::none);
    out.against.assign(s.size(), false);
    out.two_sided.assign(s.size(), false);
    out.unsure.assign(s.size(), false);
    if (s.size() < std::max<std::size_t>(options.smallest, 2)) return out;
    const std::vector<double> spacing = surround(s, out, progress);
    part_pieces(s, options.smallest, out.graph);
    std::unique_ptr<SideRays> rays;
    // Given normals tell contacts by themselves (drop_doubtful), to the point.
    if (options.estimated) rays = part_contacts(s, spacing, options.seed, out.graph, progress);
    std::vector<Vec3> front = s.normals;
    std::vector<std::vector<std::uint32_t>> members =
        groups_of(orient_sheets(s.positions, spacing, out.graph, continuation, front, progress));
    members.erase(
        std::remove_if(members.begin(), members.end(), [&](const auto& m) { return m.size() < options.smallest; }),
        members.end());
    for (std::size_t k = 0; k < members.size(); ++k) {
        const auto faces_back = [&](std::uint32_t i) { return dot(front[i], s.normals[i]) < 0.0; };
        const auto against = std::count_if(members[k].begin(), members[k].end(), faces_back);
        const bool most = 2 * static_cast<std::size_t>(against) > members[k].size();
        for (std::uint32_t i : members[k]) {
            out.sheet[i] = static_cast<std::uint32_t>(k);
            out.against[i] = faces_back(i) != most;
            if (most) front[i] = -front[i];
        }
        OrientedSheet sheet;
        sheet.size = members[k].size();
        const auto few = most ? sheet.size - static_cast<std::size_t>(against) : static_cast<std::size_t>(against);
        sheet.flat = flatness(spacing, members[k], front);
        sheet.tangled = tangled(s, out.graph, members[k], front);
        sheet.against = static_cast<double>(few) / static_cast<double>(sheet.size);
        out.sheets.push_back(sheet);
    }
    if (!rays) rays = std::make_unique<SideRays>(s, front);
    Votes(s, out, front, *rays, options).ask(members, progress);
    if (options.estimated) return out;
    settle_by_rays(s, *rays, options, out);
    drop_doubtful(s, out);
    find_side_changes(s, out);
    return out;
}

}  // namespace surflux
