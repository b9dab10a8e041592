#include "surflux/radiosity/cut_test.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/core/shared_vectors.h"

namespace surflux {

namespace {

// Between what the halves of a row's rays bring.
Rgb difference(const GatheredSystem& system, const Gathering& rows, std::uint32_t row, const std::vector<double>& sent,
               Rgb& mean) {
    double first[3], second[3];
    rows.gather_halves(row, sent, system.channels(), first, second);
    const Rgb a = system.unpack(first), b = system.unpack(second);
    mean = 0.5 * (a + b);
    return a - b;
}

// The global squared error is sum A e^2: with e as A^-1/2 all nodes have the same part in it, with e as A^0 the same
// error. The exponent is half way between, -1/4.
double smallness(double usual_area, double area) { return std::pow(std::max(1.0, usual_area / area), 0.25); }

// How many rays a node wants whose standard error is so many times what it may be: evenly spread ones, of which twice
// as many have about 2^-3/4 of the error, by powers of 2. 0: no more than it has.
int rays_for(double times, std::uint32_t rays, int most, double at_once) {
    if (!(times > 1.0)) return 0;
    int out = static_cast<int>(rays);
    for (double left = times; left > 1.0 && 2 * out <= most && out < at_once * rays; left *= 0.6) out *= 2;
    return out > static_cast<int>(rays) ? out : 0;
}

}  // namespace

CutTest::CutTest(const SurfelTree& tree, const Gathering& gathering, Gathering& probes, std::uint64_t seed,
                 const RefinementTuning& tuning)
    : tree_(tree), gathering_(gathering), probes_(probes), seed_(seed), tuning_(tuning) {}

double CutTest::standard_error(const Gathering& gathering, std::uint32_t row, const GatheredSystem& system,
                               const std::vector<double>& sent) {
    Rgb mean;
    return 0.5 * color_norm(difference(system, gathering, row, sent, mean));
}

// A leaf below a node, drawn by area.
std::uint32_t CutTest::leaf_below(std::uint32_t node, Random& random) const {
    while (!tree_.is_leaf(node)) {
        double rest = random.uniform() * tree_.area(node);
        std::uint32_t next = node;
        tree_.for_members(node, [&](std::uint32_t member) {
            if (rest >= 0.0) next = member;
            rest -= tree_.area(member);
        });
        node = next;
    }
    return node;
}

// Surfels below a group that tell whether it is like them: one drawn by area and, of some more, those that are farthest
// from its place and from each other (Gonzalez 1985), its corners: there it ends at other surfaces.
std::vector<std::uint32_t> CutTest::telling_leaves(std::uint32_t node) const {
    Random random(seed_, node);
    std::vector<std::uint32_t> drawn;
    for (long k = 0; k < std::lround(tuning_.drawn_leaves); ++k) drawn.push_back(leaf_below(node, random));
    std::vector<std::uint32_t> out{drawn.front()};
    std::vector<double> distance(drawn.size(), std::numeric_limits<double>::infinity());
    Vec3 from = tree_.position(tree_.representative(node));
    for (std::size_t corner = 0; corner < whole_number(tuning_.corners); ++corner) {
        for (std::size_t k = 0; k < drawn.size(); ++k)
            distance[k] = std::min(distance[k], length(tree_.position(drawn[k]) - from));
        const auto farthest = std::max_element(distance.begin(), distance.end());
        if (!(*farthest > 0.0)) break;
        const std::uint32_t leaf = drawn[static_cast<std::size_t>(farthest - distance.begin())];
        from = tree_.position(leaf);
        if (leaf != out.front()) out.push_back(leaf);
    }
    return out;
}

// Rays from surfels below each group that has not had any.
void CutTest::probe(const Cut& cut, const Progress& progress) {
    std::vector<std::uint32_t> groups;
    for (const std::uint32_t node : cut.nodes)
        if (!tree_.is_leaf(node) && !probes_of_.count(node)) groups.push_back(node);
    std::vector<std::vector<std::uint32_t>> leaves(groups.size());
    parallel_for(groups.size(), 64, [&](std::size_t k) { leaves[k] = telling_leaves(groups[k]); });
    std::vector<Place> fresh;
    for (std::size_t k = 0; k < groups.size(); ++k) {
        probes_of_[groups[k]] = {static_cast<std::uint32_t>(probes_.size() + fresh.size()),
                                 static_cast<std::uint32_t>(leaves[k].size())};
        for (const std::uint32_t p : leaves[k]) fresh.push_back(LitPoints::place(tree_, p));
    }
    probes_.add(fresh, std::vector<int>(fresh.size(), static_cast<int>(tuning_.probe_rays)), progress);
}

CutTest::Noise CutTest::rays_wanted(const Cut& cut, const GatheredSystem& system, const std::vector<double>& sent,
                                    const Allowed& allowed, double usual_area, int most_rays,
                                    const Progress& progress) const {
    const NodePlaces at(tree_, cut);
    const std::size_t count = cut.nodes.size();
    const Interpolation sites(at.positions, at.normals, at.objects, standing_at(0, count, progress));
    // Of one row two halves say little, and nothing where neither met what is small and bright. So nodes around are
    // asked as well, in units of what each may be off by: beyond a wall light may be another.
    std::vector<double> own(count);
    const auto digest = [&] { return digest_of(sent); };
    shared_vectors(
        system.team(), "noise", digest, 64,
        [&](std::size_t from, std::size_t to) {
            for (std::size_t k = from; k < to; ++k)
                own[k] = standard_error(gathering_, cut.rows[k], system, sent) / allowed.noise[k];
        },
        progress, own);
    const std::size_t nodes_around = whole_number(tuning_.nodes_around);
    const std::size_t fewest_aimed = whole_number(tuning_.fewest_aimed);
    Noise out;
    out.standard_error.resize(count);
    out.rays.resize(count);
    shared_vectors(
        system.team(), "rays wanted", digest, 64,
        [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                const Gathering::Row& row = gathering_.row(cut.rows[k]);
                sites.nearest(at.positions[k], at.normals[k], at.objects[k], nodes_around, near);
                double squared = 0.0;
                std::uint32_t aimed = 0, fewest = 0;
                for (const Interpolation::Weight& other : near) {
                    squared += own[other.site] * own[other.site];
                    const Gathering::Row& around = gathering_.row(cut.rows[other.site]);
                    if (!around.is_aimed()) continue;
                    fewest = aimed == 0 ? around.rays : std::min(fewest, around.rays);
                    ++aimed;
                }
                const double pooled = near.empty() ? own[k] : std::sqrt(squared / static_cast<double>(near.size()));
                out.standard_error[k] = pooled * allowed.noise[k];
                // What is not aimed knows less than nodes around that are.
                out.rays[k] = !row.is_aimed() && aimed >= fewest_aimed
                                  ? static_cast<int>(fewest)
                                  : rays_for(pooled / smallness(usual_area, tree_.area(cut.nodes[k])), row.rays,
                                             most_rays, tuning_.most_at_once);
                // What it was given already did not help.
                if (k < cut.rays.size() && out.rays[k] <= cut.rays[k]) out.rays[k] = 0;
            }
        },
        progress, out.standard_error, out.rays);
    return out;
}

CutTest::Result CutTest::operator()(const Cut& cut, const GatheredSystem& system, const std::vector<double>& values,
                                    const std::vector<double>& sent, const Allowed& allowed,
                                    const std::vector<double>& arrived, double reference, double usual_area,
                                    int most_rays, const Progress& progress) {
    probe(cut, progress);
    const NodePlaces at(tree_, cut);
    const std::size_t count = cut.nodes.size();
    const Interpolation sites(at.positions, at.normals, at.objects, standing_at(0, count, progress));
    // All light, and the part of it that is the sky's: in corners one rises as the other falls, and both are written.
    std::vector<Rgb> value(count), sky(count);
    for (std::size_t k = 0; k < count; ++k) {
        sky[k] = system.found(k);
        value[k] = system.value(values, k) + sky[k];
    }
    const bool has_sky = gathering_.has_sky();

    const Noise noise = rays_wanted(cut, system, sent, allowed, usual_area, most_rays, progress);

    const std::size_t nodes_around = whole_number(tuning_.nodes_around);
    // What the nodes around say at the place of one.
    const auto said_by_others = [&](std::size_t k, std::vector<Interpolation::Weight>& near, Rgb& of_sky) {
        sites.nearest(at.positions[k], at.normals[k], at.objects[k], nodes_around, near);
        Rgb said;
        double sum = 0.0;
        of_sky = {};
        for (const Interpolation::Weight& other : near) {
            const double h = near.back().weight;
            if (other.site == k || !(other.weight > 0.0) || other.weight >= h) continue;
            const double root = (h - other.weight) / (h * other.weight);
            said += root * root * value[other.site];
            of_sky += root * root * sky[other.site];
            sum += root * root;
        }
        if (sum > 0.0) of_sky = of_sky / sum;
        return sum > 0.0 ? said / sum : Rgb{};
    };
    // By how much all are off at the probe of a node, as far as it can tell.
    const auto off_at_probe = [&](std::size_t k, std::uint32_t row, double spread,
                                  std::vector<Interpolation::Weight>& near) {
        const Place& place = probes_.place(row);
        sites.at(place.position, place.normal, at.objects[k], near);
        Rgb said, seen, of_sky;
        for (const Interpolation::Weight& w : near) said += w.weight * value[w.site], of_sky += w.weight * sky[w.site];
        const Rgb halves = difference(system, probes_, row, sent, seen), seen_sky = probes_.sky()[row].value;
        const double fewer = gathering_.row(cut.rows[k]).rays / tuning_.probe_rays;
        const auto beyond_chance = [&](const Rgb& off, const Rgb& of, double chance) {
            return color_norm(off) - tuning_.significance * std::max(chance, tuning_.probe_error * color_norm(of));
        };
        const double chance = std::max(0.5 * color_norm(halves), std::sqrt(fewer) * spread);
        const double all = beyond_chance(seen + seen_sky - said, seen + seen_sky, chance);
        if (!has_sky) return all;
        return std::max({all, beyond_chance(seen - (said - of_sky), seen, chance),
                         beyond_chance(seen_sky - of_sky, seen_sky, 0.0)});
    };

    Result out;
    out.refine.assign(count, 0);
    out.rays = noise.rays;
    std::vector<double> squared(count, 0.0);
    shared_vectors(
        system.team(), "test of the cut", [&] { return digest_of(sent); }, 64,
        [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                const std::uint32_t node = cut.nodes[k];
                const double spread = noise.standard_error[k];
                double interpolation_error = 0.0;
                if (!tree_.is_leaf(node)) {
                    Rgb sky_around;
                    const Rgb around = said_by_others(k, near, sky_around);
                    const double reach = std::sqrt(tree_.area(node) / pi) * gathering_.row(cut.rows[k]).closeness;
                    const double close_by = tuning_.closeness_weight *
                                            gathering_.deviation(cut.rows[k], sent, system.channels()) * reach * reach;
                    double off =
                        std::max(color_norm(value[k] - around), has_sky ? color_norm(sky[k] - sky_around) : 0.0);
                    const auto [first, probes] = probes_of_.at(node);
                    for (std::uint32_t row = first; row < first + probes; ++row)
                        off = std::max(off, off_at_probe(k, row, spread, near));
                    off -= tuning_.significance * spread;
                    out.refine[k] =
                        std::max(close_by, off) > allowed.error[k] * smallness(usual_area, tree_.area(node));
                    const double most = std::min(std::max(close_by, off), color_norm(value[k] + around));
                    // Second order: between neighbours on all sides, half as far, a quarter of it.
                    interpolation_error = 0.25 * std::max(0.0, out.refine[k] ? most : off);
                }
                if (!arrived.empty() && arrived[k] > allowed.error[k] &&
                    color_norm(value[k]) < tuning_.missed * arrived[k]) {
                    out.refine[k] = out.refine[k] || !tree_.is_leaf(node);
                    const int more = 2 * static_cast<int>(gathering_.row(cut.rows[k]).rays);
                    if (more <= most_rays && (k >= cut.rays.size() || more > cut.rays[k]))
                        out.rays[k] = std::max(out.rays[k], more);
                }
                squared[k] = spread * spread + interpolation_error * interpolation_error;
            }
        },
        progress, out.refine, out.rays, squared);
    double sum = 0.0, total = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
        const double area = tree_.area(cut.nodes[k]);
        sum += area * squared[k];
        total += area;
    }
    out.error = reference > 0.0 ? std::sqrt(sum / total) / reference : 0.0;
    return out;
}

}  // namespace surflux
