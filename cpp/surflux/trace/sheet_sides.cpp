#include "surflux/trace/sheet_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t links = 12;        // neighbours that may continue a surfel
constexpr std::size_t witnesses = 2000;  // at most, of a sheet
constexpr double flattest = 0.3;         // cosine of a ray; nearer the disk it meets the rims of others
constexpr double closed = 0.6;           // part of the light that reaches a closed sheet from one side alone
constexpr double most_flat = 0.5;        // as of half a sphere: what is flatter closes around nothing
constexpr double dark = 0.02;         // of the rays: of a sheet that is itself inside of another, fewer leave the scene
constexpr double furnished = 0.02;    // of the rays: so many meet bodies inside of a room
constexpr double no_crease = 0.8;     // cosine; at a crease, two leaves touch as the sides of a box do
constexpr double few_against = 0.05;  // what is tangled, but faces the same way nearly everywhere, has two sides, too
constexpr double doubtful = 0.25;     // of the links across the border of a patch: more, and it is none
constexpr double least_border = 12.0;   // links, and the root of its surfels: fewer are a contact, as of two leaves
constexpr double most_tangled = 0.002;  // see OrientedSheet
constexpr std::size_t looks = 256;      // of a witness, all around
constexpr double around = 0.5;          // of these meet the inside of what closes around it

Scene as_scene(const Surfels& surfels, std::vector<Vec3> normals, bool turned) {
    Scene out;
    out.surfels = surfels;
    out.surfels.normals = std::move(normals);
    out.object.assign(surfels.size(), 0);
    for (Triangle& t : out.surfels.triangles)
        if (dot(out.surfels.normals[t.surfel], surfels.normals[t.surfel]) < 0.0) std::swap(t.b, t.c);
    if (turned) {
        for (Vec3& n : out.surfels.normals) n = -n;
        for (Triangle& t : out.surfels.triangles) std::swap(t.b, t.c);
    }
    return out;
}

// What a ray from a side of a sheet met: nothing, or a surfel on the side that its normal in the scene points to.
struct Met {
    std::uint32_t surfel = Hit::none;
    bool front = false;
};

// Of `rays` rays from the front of each of `from`.
std::vector<Met> rays_from(const Scene& scene, const std::vector<std::uint32_t>& from, const SheetOptions& options,
                           const Progress& progress) {
    const Surfels& s = scene.surfels;
    const auto rays = static_cast<std::size_t>(options.rays);
    std::vector<Met> out(from.size() * rays);
    if (from.empty()) return out;
    const Tracer tracer(scene);
    parallel_blocks(
        from.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = from[k];
                const Frame frame = frame_around(s.normals[i]);
                EvenPoints even(2, options.seed, i);
                for (std::size_t r = 0; r < rays; ++r) {
                    const double* u = even.next();
                    Vec3 d = square_to_cosine_hemisphere(u[0], u[1]);
                    d.z = std::max(d.z, flattest);
                    const Ray ray{{s.positions[i], s.normals[i], i}, frame.to_world(normalized(d))};
                    const Hit hit = tracer.closest(ray);
                    if (hit) out[k * rays + r] = {hit.surfel, dot(s.normals[hit.surfel], ray.direction) < 0.0};
                }
            }
        },
        progress);
    return out;
}

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

// Where the rays of one side of a sheet went, as shares of them. Sides: 0 in front, 1 behind.
struct Side {
    double leave = 0.0, others = 0.0;
    double seen() const { return leave + others; }
};
using Sides = std::array<Side, 2>;

double margin_of(double a, double b) { return a + b > 0.0 ? (a - b) / (a + b) : 0.0; }

class Votes {
public:
    Votes(const Surfels& s, SheetSides& out, const std::vector<Vec3>& front, const SheetOptions& options)
        : s_(s), out_(out), front_(front), options_(options), sides_(out.sheets.size()) {}

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
            met_[behind] = rays_from(as_scene(s_, front_, behind), asked_, options_, half);
            count(behind);
        }
        for (std::size_t k = 0; k < sides_.size(); ++k) decide_by_light(k);
        count_bodies();
        hear_witnesses();
        for (std::size_t k = 0; k < sides_.size(); ++k) find_room(k);
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
        const bool is_dark = front.leave + behind.leave < 2.0 * dark;
        sheet.margin = is_dark ? margin_of(front.seen(), behind.seen()) : margin_of(front.leave, behind.leave);
        if (std::abs(sheet.margin) <= closed || sheet.flat > most_flat) return;
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
                // The scene of rays from behind has all normals turned.
                const bool met_front = met.front != behind;
                if (met_front != out_.sheets[other].backwards) bodies_[sheet] += weight(sheet);
            });
    }

    // How much of what a witness sees is the inside of one body.
    void hear_witnesses() {
        witnessed_.assign(sides_.size(), 0.0);
        if (options_.witnesses.empty()) return;
        const Scene scene = as_scene(s_, front_, false);
        const Tracer tracer(scene);
        for (const Vec3& at : options_.witnesses) {
            std::vector<double> inside(sides_.size(), 0.0);
            EvenPoints even(2, options_.seed, 0);
            for (std::size_t r = 0; r < looks; ++r) {
                const double* u = even.next();
                const double z = 2.0 * u[0] - 1.0, across = std::sqrt(1.0 - z * z), phi = 2.0 * pi * u[1];
                const Vec3 d{across * std::cos(phi), across * std::sin(phi), z};
                const Hit hit = tracer.closest({{at, d, Hit::none}, d});
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
        const bool is_furnished = front.leave + behind.leave >= 2.0 * dark && bodies_[k] >= furnished;
        if (!is_furnished && witnessed_[k] < around) return;
        sheet.kind = SheetKind::room;
        sheet.backwards = !sheet.backwards;
    }

    const Surfels& s_;
    SheetSides& out_;
    const std::vector<Vec3>& front_;  // normals, alike in each sheet, and as most of its surfels have them
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
void drop_doubtful(const Surfels& s, SheetSides& out) {
    for (const std::vector<std::uint32_t>& patch : patches_of(s, out.graph, out.against)) {
        const bool is_open = out.sheets[out.sheet[patch.front()]].kind == SheetKind::open;
        std::size_t same = 0, opposite = 0, smooth = 0;
        for (std::uint32_t i : patch)
            for (std::uint32_t j : out.graph[i]) {
                if (out.against[j] || out.two_sided[j]) continue;
                const double agree = agreement(s.normals[i], s.normals[j], s.positions[j] - s.positions[i]);
                const double cosine = dot(s.normals[i], s.normals[j]);
                if (std::abs(agree) < continuation || mirror_decides(agree, cosine)) continue;
                ++(agree > 0.0 ? same : opposite);
                smooth += agree < 0.0 && cosine < -no_crease;
            }
        const double border = std::max(least_border, std::sqrt(static_cast<double>(patch.size())));
        if (static_cast<double>(is_open ? smooth : opposite) < border || (is_open && 2 * smooth < opposite) ||
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
    if (of.tangled <= most_tangled) return against[surfel] != of.backwards;
    return of.backwards && !against[surfel] && of.against <= few_against;
}

SheetSides sheet_sides(const Surfels& s, const SheetOptions& options, const Progress& progress) {
    SheetSides out;
    out.sheet.assign(s.size(), SheetSides::none);
    out.against.assign(s.size(), false);
    out.two_sided.assign(s.size(), false);
    if (s.size() < std::max<std::size_t>(options.smallest, 2)) return out;
    const std::vector<double> spacing = surround(s, out, progress);
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
    Votes(s, out, front, options).ask(members, progress);
    drop_doubtful(s, out);
    return out;
}

}  // namespace surflux
