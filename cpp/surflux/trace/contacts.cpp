#include "surflux/trace/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/signed_forest.h"
#include "surflux/trace/sheet_sides.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 16;         // surfels of the clusters that pieces are made of
constexpr std::size_t least_piece = 100;  // surfels; smaller ones are noise
constexpr std::size_t looking = 30'000;   // surfels from which rays go, at most; one from each side
// Links that a ray is worth. Of balls of 8000 points on floors 120 to 330 links speak for what 1300 to 1700 rays, net
// 1000 and more, speak against.
constexpr double seen_weight = 4.0;
constexpr double near_by = 2.0;      // sums of spacings: rays that end nearer say nothing, where noise is
constexpr double least_seen = 10.0;  // rays, net: fewer say nothing
// Links, and the root of its surfels: fewer are a contact. Borders of pieces that grow have 6 to 10 roots.
constexpr double least_border = 12.0;

struct Link {
    float weight, agree;
    std::uint32_t a, b;
    bool operator<(const Link& other) const {
        return std::tie(weight, a, b) < std::tie(other.weight, other.a, other.b);
    }
};

// The links that orient_sheets takes.
std::vector<Link> sure_links(const Surfels& s, const std::vector<double>& spacing, const NeighborGraph& graph) {
    std::vector<std::size_t> start(s.size() + 1, 0);
    for (std::size_t i = 0; i < s.size(); ++i) start[i + 1] = start[i] + graph[i].size();
    std::vector<Link> out(start.back());
    parallel_for(s.size(), 1024, [&](std::size_t i) {
        for (std::size_t k = 0; k < graph[i].size(); ++k) {
            const std::uint32_t from = static_cast<std::uint32_t>(i), to = graph[i][k];
            const TreeLink link(s.normals[i], s.normals[to], s.positions[to] - s.positions[i],
                                spacing[i] + spacing[to]);
            const bool counts = std::abs(link.agree) >= continuation && !link.is_doubtful;
            out[start[i] + k] = {static_cast<float>(link.weight), counts ? static_cast<float>(link.agree) : 0.0f,
                                 std::min(from, to), std::max(from, to)};
        }
    });
    out.erase(std::remove_if(out.begin(), out.end(), [](const Link& link) { return link.agree == 0.0f; }), out.end());
    std::sort(out.begin(), out.end());
    return out;
}

// What links and rays say of two clusters: that their fronts are on one side of what they bound, or that they are not.
struct Tie {
    std::uint32_t a, b;
    double same = 0.0, opposite = 0.0, seen_same = 0.0, seen_opposite = 0.0;
    bool apart = false;

    bool operator<(const Tie& other) const { return std::tie(a, b) < std::tie(other.a, other.b); }
    void turn() {
        std::swap(same, opposite);
        std::swap(seen_same, seen_opposite);
    }
    void add(const Tie& other) {
        same += other.same, opposite += other.opposite;
        seen_same += other.seen_same, seen_opposite += other.seen_opposite;
        apart = apart || other.apart;
    }
};

class Pieces {
public:
    Pieces(const Surfels& s, const std::vector<double>& spacing, std::uint64_t seed, const NeighborGraph& graph,
           const Progress& progress)
        : s_(s), spacing_(spacing), forest_(s.size()) {
        const std::vector<Link> links = sure_links(s, spacing, graph);
        for (const Link& link : links) {
            const std::uint32_t a = forest_.root(link.a), b = forest_.root(link.b);
            if (a != b && forest_.size(a) + forest_.size(b) <= grain) forest_.join(link.a, link.b, link.agree < 0.0f);
        }
        for (const Link& link : links) {
            const double agree = std::abs(static_cast<double>(link.agree));
            Tie tie{link.a, link.b};
            (link.agree < 0.0f ? tie.opposite : tie.same) = agree;
            ties_.push_back(tie);
        }
        gather();
        // By links alone first, so that rays leave surfaces that are alike all over.
        const SignedForest grains = forest_;
        const std::vector<Tie> ties = ties_;
        while (grow(false)) gather();
        std::vector<Vec3> front = s.normals;
        front_turned_.resize(s.size());
        for (std::uint32_t i = 0; i < s.size(); ++i) {
            bool turned;
            forest_.root(i, turned);
            front_turned_[i] = turned;
            if (turned) front[i] = -front[i];
        }
        forest_ = grains;
        ties_ = ties;
        rays_ = std::make_unique<SideRays>(s, front);
        look(front, seed, progress);
        gather();
        while (grow(true)) gather();
    }

    // Whether links between surfels i and j are to be taken out.
    bool apart() const { return any_apart_; }
    std::unique_ptr<SideRays> rays() { return std::move(rays_); }
    std::vector<std::uint32_t> bodies();

private:
    void look(const std::vector<Vec3>& front, std::uint64_t seed, const Progress& progress) {
        step_ = (s_.size() + looking - 1) / looking;
        for (std::size_t i = 0; i < s_.size(); i += step_) from_.push_back(static_cast<std::uint32_t>(i));
        for (const bool behind : {false, true}) {
            met_[behind] = rays_->cast(from_, front, behind, 1, seed, progress);
            for (std::size_t k = 0; k < from_.size(); ++k) {
                const std::uint32_t i = from_[k], j = met_[behind][k].surfel;
                if (j == Hit::none) continue;
                if (length(s_.positions[i] - s_.positions[j]) < near_by * (spacing_[i] + spacing_[j])) continue;
                // A ray from a front bounds with the front that it meets the same air, or the same solid.
                Tie tie{i, j};
                const bool opposite = (met_[behind][k].front == behind) ^ front_turned_[i] ^ front_turned_[j];
                (opposite ? tie.seen_opposite : tie.seen_same) = 1.0;
                ties_.push_back(tie);
            }
        }
    }

    // Ties of clusters as they are now.
    void gather() {
        std::size_t kept = 0;
        for (Tie tie : ties_) {
            bool turned_a, turned_b;
            tie.a = forest_.root(tie.a, turned_a), tie.b = forest_.root(tie.b, turned_b);
            if (tie.a == tie.b) continue;
            if (tie.a > tie.b) std::swap(tie.a, tie.b);
            if (turned_a != turned_b) tie.turn();
            ties_[kept++] = tie;
        }
        ties_.resize(kept);
        std::stable_sort(ties_.begin(), ties_.end());
        kept = 0;
        for (const Tie& tie : ties_)
            if (kept > 0 && ties_[kept - 1].a == tie.a && ties_[kept - 1].b == tie.b)
                ties_[kept - 1].add(tie);
            else
                ties_[kept++] = tie;
        ties_.resize(kept);
    }

    // Joins those clusters that have no better tie than the one between them: by links, of clusters as large as these.
    // So necks come last. False: there are none.
    bool grow(bool parting) {
        std::vector<double> best(s_.size(), 0.0);
        std::vector<std::uint32_t> of(s_.size());
        for (std::uint32_t k = 0; k < ties_.size(); ++k) {
            const Tie& tie = ties_[k];
            if (tie.apart) continue;
            const double strength = std::abs(tie.same - tie.opposite) / std::sqrt(size(tie.a) * size(tie.b));
            for (const std::uint32_t c : {tie.a, tie.b})
                if (strength > best[c]) best[c] = strength, of[c] = k;
        }
        bool any = false;
        for (std::uint32_t k = 0; k < ties_.size(); ++k) {
            Tie& tie = ties_[k];
            if (best[tie.a] == 0.0 || best[tie.b] == 0.0 || of[tie.a] != k || of[tie.b] != k) continue;
            any = true;
            if (parting && is_contact(tie))
                tie.apart = any_apart_ = true;
            else
                forest_.join(tie.a, tie.b, tie.opposite > tie.same);
        }
        return any;
    }

    double size(std::uint32_t root) const { return static_cast<double>(forest_.size(root)); }

    bool is_contact(const Tie& tie) const {
        const double smaller = std::min(size(tie.a), size(tie.b)), links = tie.same - tie.opposite;
        if (smaller < static_cast<double>(least_piece)) return false;
        if (std::abs(links) < std::max(least_border, std::sqrt(smaller))) return true;
        const double seen = tie.seen_same - tie.seen_opposite;
        const double weight = seen_weight * static_cast<double>(step_);
        return seen * links < 0.0 && std::abs(seen) > least_seen && weight * std::abs(seen) > std::abs(links);
    }

    const Surfels& s_;
    const std::vector<double>& spacing_;
    SignedForest forest_;
    std::size_t step_ = 1;
    std::vector<std::uint32_t> from_;
    std::unique_ptr<SideRays> rays_;
    std::vector<char> front_turned_;  // of what links alone say
    std::array<std::vector<Met>, 2> met_;
    std::vector<Tie> ties_;
    bool any_apart_ = false;
};

// Light that comes to a piece, as in Votes.
struct Seen {
    std::array<double, 2> leave{}, others{};
    double all = 0.0, area = 0.0;
    Vec3 sum;
    bool one_sided() const {
        std::array<double, 2> light = leave;
        if (leave[0] + leave[1] < 2.0 * closing::dark * all)
            for (const std::size_t side : {0, 1}) light[side] += others[side];
        const double both = light[0] + light[1];
        return both > 0.0 && std::abs(light[0] - light[1]) > closing::one_sided * both;
    }
    bool is_flat() const { return length(sum) > closing::most_flat * area; }
};

// Per surfel: the root of the body it is in, or its size for none.
std::vector<std::uint32_t> Pieces::bodies() {
    std::vector<Seen> seen;
    std::vector<std::uint32_t> piece(s_.size());
    std::vector<char> turned(s_.size());
    const auto measure = [&] {
        seen.assign(s_.size(), {});
        for (std::uint32_t i = 0; i < s_.size(); ++i) {
            bool is_turned;
            piece[i] = forest_.root(i, is_turned);
            turned[i] = is_turned;
            const double area = spacing_[i] * spacing_[i];
            seen[piece[i]].area += area;
            seen[piece[i]].sum += (is_turned ? -area : area) * s_.normals[i];
        }
        for (const std::size_t behind : {0, 1})
            for (std::size_t k = 0; k < from_.size(); ++k) {
                const std::uint32_t i = from_[k], j = met_[behind][k].surfel;
                Seen& of = seen[piece[i]];
                const std::size_t side = behind ^ static_cast<std::size_t>(turned[i] != front_turned_[i]);
                of.all += 0.5;
                if (j == Hit::none)
                    of.leave[side] += 1.0;
                else if (piece[j] != piece[i])
                    of.others[side] += 1.0;
            }
    };
    measure();
    // What is lit from one side, but flat, is a part of the body that it hangs on by the most links.
    std::vector<double> most(s_.size(), 0.0);
    std::vector<const Tie*> by(s_.size(), nullptr);
    for (const Tie& tie : ties_)
        for (const bool swapped : {false, true}) {
            const std::uint32_t part = swapped ? tie.b : tie.a, body = swapped ? tie.a : tie.b;
            const double links = tie.same + tie.opposite;
            if (!seen[part].one_sided() || !seen[part].is_flat() || !seen[body].one_sided() || seen[body].is_flat())
                continue;
            if (links > most[part]) most[part] = links, by[part] = &tie;
        }
    for (const Tie* tie : by)
        if (tie != nullptr) forest_.join(tie->a, tie->b, tie->opposite > tie->same);
    measure();
    for (std::uint32_t i = 0; i < s_.size(); ++i)
        if (!seen[piece[i]].one_sided() || seen[piece[i]].is_flat() || forest_.size(piece[i]) < least_piece)
            piece[i] = std::numeric_limits<std::uint32_t>::max();
    return piece;
}

}  // namespace

std::unique_ptr<SideRays> part_contacts(const Surfels& s, const std::vector<double>& spacing, std::uint64_t seed,
                                        NeighborGraph& graph, const Progress& progress) {
    Pieces pieces(s, spacing, seed, graph, standing_at(0, 1, progress));
    if (pieces.apart()) {
        const std::vector<std::uint32_t> body = pieces.bodies();
        for (std::uint32_t i = 0; i < s.size(); ++i) {
            const auto is_apart = [&](std::uint32_t j) { return body[i] != body[j]; };
            graph[i].erase(std::remove_if(graph[i].begin(), graph[i].end(), is_apart), graph[i].end());
        }
    }
    return pieces.rays();
}

}  // namespace surflux
