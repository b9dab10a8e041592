#include "surflux/transfer/group_light.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 64;  // nodes whose rays are traced together
constexpr int levels_at_once = 7;  // of the tree, below which subtrees are planned side by side
constexpr std::uint64_t light_stream = 0x6c1, ray_stream = 0x6c2, beam_stream = 0x6c3, end_stream = 0x6c4,
                        drawn_stream = 0x6c5;
constexpr int points_of_light = 64;  // of which one is to be over the horizon
// Of a light that is wide beside its distance: so many times the rays, at most so many from a leaf, each to one of so
// many points over the horizon.
constexpr std::size_t more_rays = 4, most_wide = 64;
constexpr int candidates = 2;
// Walls make many groups that would send next to nothing. Of those that want less than `certain` of a ray some are
// drawn, and count for the others (Russian roulette, Arvo and Kirk 1990): neighbours by turns, and mostly the same ones
// while a lamp moves.
constexpr double certain = 0.1, least_chance = 0.25, golden_section = 0.6180339887498949;
constexpr std::size_t together = 16;  // places whose light is asked for at once

}  // namespace

struct GroupLight::Unoccluded {
    std::vector<float> kernels;  // of each sample
    std::vector<Vec3> from;      // where its shadow ray ends; empty where that is one place for all
    std::vector<char> is_wide;   // of each sample (Emitter::is_wide_at): each ray from there ends elsewhere
    Vec3 from_all;
    std::vector<float> means;  // of the kernel, by leaf
    std::vector<float> power;  // that each node would send
    // Of leaves that light meets between all of their samples: where, and from where.
    struct Met {
        Vec3 position, from;
        std::uint32_t surfel;
    };
    std::map<std::size_t, Met> beams;
    std::mutex mutex;  // of these
    // Of leaves with disks that share what is narrower than they are: what these have, occluded, and of all of the
    // leaf.
    std::map<std::size_t, double> shared;
};

struct GroupLight::Shot {
    std::uint32_t node;
    std::uint32_t rays;  // more than one of leaves alone
    float weight;        // one over the chance of having been drawn
};

GroupLight::GroupLight(const CompiledScene& scene, const SenderGroups& groups, const SenderSamples& samples,
                       const SurfelPoints& points, const std::vector<double>& areas)
    : scene_(scene),
      groups_(groups),
      samples_(samples),
      points_(points),
      areas_(areas),
      of_leaves_(groups),
      extents_(groups.leaves.size()) {
    const Surfels& s = scene.scene().surfels;
    for (std::uint32_t i = 0; i < s.size() && !has_disks_; ++i) has_disks_ = !points.is_patch(i);
    parallel_for(extents_.size(), 256, [&](std::size_t leaf) {
        Extent& extent = extents_[leaf];
        NormalCone& all = extent.normals;
        double count = 0.0;
        for_lit(leaf, [&](std::uint32_t i) { all.center += s.positions[i], all.axis += s.normals[i], count += 1.0; });
        all.center = all.center / std::max(1.0, count);
        all.axis = all.axis / std::max(1.0, count);
        for_lit(leaf, [&](std::uint32_t i) {
            const Vec3 to_center = all.center - s.positions[i];
            extent.radius = std::max(extent.radius, length(to_center) + s.radii[i]);
            all.height = std::max(all.height, dot(s.normals[i], to_center));
            all.spread = std::max(all.spread, length(s.normals[i] - all.axis));
        });
    });
}

// What mean_over_surfels reads, while other leaves are seen to: to wait for each takes half of the time.
void GroupLight::fetch_surfels(std::size_t leaf) const {
    const Surfels& s = scene_.scene().surfels;
    of_leaves_.for_leaf(leaf, [&](std::uint32_t i) {
        __builtin_prefetch(&areas_[i]);
        __builtin_prefetch(&s.positions[i]);
        __builtin_prefetch(&s.normals[i]);
        __builtin_prefetch(&s.radii[i]);
    });
}

// But what disks share.
double GroupLight::mean_over_surfels(const Emitter& light, const NarrowLight& narrow, std::size_t leaf) const {
    const Surfels& s = scene_.scene().surfels;
    double sum = 0.0, all = 0.0;
    std::uint32_t surfels[together];
    Vec3 at[together], normals[together];
    double kernels[together];
    std::size_t count = 0;
    const auto add = [&] {
        light.kernels_at(at, normals, count, kernels);
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint32_t i = surfels[k];
            sum += areas_[i] * (light.is_even_in(at[k], s.radii[i])
                                    ? kernels[k]
                                    : light.mean_kernel({points_, i, i, at[k], normals[k], true}));
        }
        count = 0;
    };
    for_lit(leaf, [&](std::uint32_t i) {
        all += areas_[i];
        if (narrow.of(light.index, i) != nullptr) return;
        surfels[count] = i, at[count] = s.positions[i], normals[count] = s.normals[i];
        if (++count == together) add();
    });
    add();
    return all > 0.0 ? sum / all : 0.0;
}

// On the surfel of a leaf that has most of the light.
void GroupLight::find_beam(const Emitter& light, const NarrowLight& narrow, std::size_t leaf, std::uint64_t seed,
                           Unoccluded& out) const {
    const Surfels& s = scene_.scene().surfels;
    double most = 0.0;
    Unoccluded::Met met{};
    for_lit(leaf, [&](std::uint32_t i) {
        const Receiver receiver{points_, i, i, s.positions[i], s.normals[i], true};
        const double power = areas_[i] * light.mean_kernel(receiver);
        if (!(power > most) || narrow.of(light.index, i) != nullptr) return;
        most = power;
        met = {s.positions[i], {}, i};
        std::vector<Triangle> lit;
        light.find_lit(receiver, lit);
        const auto less = [](const Triangle& a, const Triangle& b) { return area_of(a) < area_of(b); };
        if (const auto largest = std::max_element(lit.begin(), lit.end(), less); largest != lit.end())
            met.position = points_.inset(i, (largest->a + largest->b + largest->c) / 3.0);
    });
    // Of a lamp that hardly rises over the horizon a point that does.
    EvenPoints even(2, seed + beam_stream, leaf);
    double highest = -1.0;
    for (int k = 0; k < points_of_light; ++k) {
        const double* u = even.next();
        const Arrival arrival = light.arrival(met.position, s.normals[met.surfel], u[0], u[1]);
        if (arrival.kernel > highest) highest = arrival.kernel, met.from = arrival.from;
    }
    const std::lock_guard lock(out.mutex);
    out.beams[leaf] = met;
}

void GroupLight::find_unoccluded(const Emitter& light, const NarrowLight& narrow, const std::vector<float>& reflectance,
                                 std::uint64_t seed, Unoccluded& out) const {
    const std::size_t leaves = groups_.leaves.size(), n = samples_.of_leaf;
    if (!narrow.is_empty())
        for (const auto& [surfel, part] : narrow.lit(light.index))
            if (areas_[surfel] > 0.0)
                out.shared[of_leaves_.number[groups_.leaf_of_surfel[surfel]]] += areas_[surfel] * part.irradiance;
    for (auto& [leaf, sum] : out.shared) {
        double area = 0.0;
        for_lit(leaf, [&](std::uint32_t i) { area += areas_[i]; });
        sum /= area;
    }
    out.kernels.resize(leaves * n);
    out.means.resize(leaves);
    out.power.resize(groups_.size());
    if (light.extended) out.from.resize(leaves * n);
    out.is_wide.assign(light.extended ? leaves * n : 0, 0);
    if (leaves > 0) out.from_all = light.arrival(samples_.position(0), samples_.normal(0), 0.5, 0.5).from;
    parallel_blocks(leaves, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Vec3> at(n), normals(n);
        std::vector<double> kernels(n);
        std::vector<std::pair<std::size_t, double>> uneven;  // leaves, and the sums of their samples
        const auto keep = [&](std::size_t leaf, double mean) {
            const std::size_t node = groups_.leaves[leaf];
            double reflected = 0.0;
            for (int c = 0; c < 3; ++c)
                reflected +=
                    light.color[c] * static_cast<double>(reflectance[colors * node + static_cast<std::size_t>(c)]);
            out.means[leaf] = static_cast<float>(mean);
            out.power[node] = groups_.nodes[node].area * static_cast<float>(reflected) * out.means[leaf];
        };
        for (std::size_t leaf = begin; leaf < end; ++leaf) {
            if (light.is_behind(extents_[leaf].normals)) continue;
            for (std::size_t k = 0; k < n; ++k)
                at[k] = samples_.position(leaf * n + k), normals[k] = samples_.normal(leaf * n + k);
            if (light.extended) {
                EvenPoints even(2, seed + light_stream, leaf);
                for (std::size_t k = 0, p = leaf * n; k < n; ++k, ++p) {
                    const double* u = even.next();
                    const Arrival arrival = light.arrival(at[k], normals[k], u[0], u[1]);
                    out.from[p] = arrival.from;
                    out.is_wide[p] = light.is_wide_at(at[k]);
                    kernels[k] = out.is_wide[p] ? light.kernel_at(at[k], normals[k]) : arrival.kernel;
                }
            } else {
                light.kernels_at(at.data(), normals.data(), n, kernels.data());
            }
            double sum = 0.0;
            for (std::size_t k = 0, p = leaf * n; k < n; ++k, ++p) {
                if (narrow.of(light.index, samples_.samples[p].surfel) != nullptr) continue;
                out.kernels[p] = static_cast<float>(kernels[k]);
                sum += kernels[k];
            }
            if (!light.is_even_in(extents_[leaf].normals.center, extents_[leaf].radius) || out.shared.count(leaf) > 0) {
                uneven.emplace_back(leaf, sum);
                fetch_surfels(leaf);
            } else {
                keep(leaf, sum / static_cast<double>(n));
            }
        }
        for (const auto& [leaf, sum] : uneven) {
            const double mean = mean_over_surfels(light, narrow, leaf);
            if (mean > 0.0 && !(sum > 0.0)) find_beam(light, narrow, leaf, seed, out);
            keep(leaf, mean);
        }
    });
    for (std::size_t k = groups_.size(); k-- > 0;)
        if (const SenderGroups::Node& node = groups_.nodes[k]; !node.is_leaf())
            out.power[k] = out.power[node.child] + out.power[node.child + 1];
}

// How many samples of a leaf the light is wide at.
std::size_t GroupLight::wide_samples(const Unoccluded& light, std::size_t leaf) const {
    if (light.is_wide.empty()) return 0;
    const char* of_leaf = light.is_wide.data() + leaf * samples_.of_leaf;
    return static_cast<std::size_t>(std::count(of_leaf, of_leaf + samples_.of_leaf, 1));
}

// The share of all that the groups would send of light that is wide where they are.
double GroupLight::wide_share(const Unoccluded& light) const {
    if (light.is_wide.empty() || !(light.power[0] > 0.0f)) return 0.0;
    double wide = 0.0;
    for (std::size_t leaf = 0; leaf < groups_.leaves.size(); ++leaf)
        wide += static_cast<double>(light.power[groups_.leaves[leaf]]) *
                static_cast<double>(wide_samples(light, leaf)) / static_cast<double>(samples_.of_leaf);
    return wide / static_cast<double>(light.power[0]);
}

// Where a ray from a sample ends: at one of some points of the light, drawn by what they bring.
Vec3 GroupLight::end_of(const Emitter& emitter, std::size_t sample, Random& random) const {
    Vec3 from;
    double all = 0.0;
    int over_horizon = 0;
    for (int k = 0; k < points_of_light && over_horizon < candidates; ++k) {
        const double s = random.uniform(), t = random.uniform();
        const Arrival arrival = emitter.arrival(samples_.position(sample), samples_.normal(sample), s, t);
        over_horizon += arrival.kernel > 0.0;
        all += arrival.kernel;
        if (random.uniform() * all <= arrival.kernel) from = arrival.from;
    }
    return from;
}

// A cut through the tree below which each node has a ray or, of leaves, more. Where a ray arrives on one side of a wall
// says nothing of the other.
std::vector<GroupLight::Shot> GroupLight::plan(const Unoccluded& light, std::size_t rays, bool across,
                                               std::uint64_t seed) const {
    std::vector<Shot> out;
    const double all = groups_.size() > 0 ? static_cast<double>(light.power[0]) : 0.0;
    if (!(all > 0.0)) return out;
    const double offset = Random(seed + drawn_stream).uniform(), scale = static_cast<double>(rays) / all;
    const auto wanted_of = [&](std::uint32_t node) { return scale * static_cast<double>(light.power[node]); };
    const auto fraction = [](double value) { return value - std::floor(value); };
    const auto is_cut = [&](std::uint32_t k) {
        const double wanted = groups_.nodes[k].is_leaf() ? 0.0 : wanted_of(k);
        return wanted > 1.0 || (wanted > 0.0 && !across && groups_.nodes[k].is_walled());
    };
    const auto add = [&](std::uint32_t k, std::vector<Shot>& shots) {
        const SenderGroups::Node& node = groups_.nodes[k];
        const double wanted = wanted_of(k);
        if (wanted == 0.0) return;
        // Of what would share a ray but for a wall.
        const bool is_part_of_one = node.parent != SenderGroups::none && wanted_of(node.parent) <= 1.0;
        const double chance = is_part_of_one ? std::clamp(std::sqrt(wanted / certain), least_chance, 1.0) : 1.0;
        if (chance < 1.0 && fraction(offset + golden_section * static_cast<double>(k)) >= chance) return;
        const std::size_t most = !node.is_leaf()                                 ? 1
                                 : wide_samples(light, of_leaves_.number[k]) > 0 ? most_wide
                                                                                 : samples_.of_leaf;
        const auto count = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1, most);
        shots.push_back({k, static_cast<std::uint32_t>(count), static_cast<float>(1.0 / chance)});
    };
    // Subtrees side by side.
    std::vector<std::uint32_t> tops{0};
    for (int level = 0; level < levels_at_once; ++level) {
        std::vector<std::uint32_t> below;
        for (const std::uint32_t k : tops) {
            const std::uint32_t child = groups_.nodes[k].child;
            if (is_cut(k))
                below.insert(below.end(), {child, child + 1});
            else
                below.push_back(k);
        }
        tops.swap(below);
    }
    std::vector<std::vector<Shot>> of_tops(tops.size());
    parallel_for(tops.size(), 1, [&](std::size_t top) {
        for (std::vector<std::uint32_t> open{tops[top]}; !open.empty();) {
            const std::uint32_t k = open.back(), child = groups_.nodes[k].child;
            open.pop_back();
            if (is_cut(k))
                open.insert(open.end(), {child + 1, child});
            else
                add(k, of_tops[top]);
        }
    });
    for (const std::vector<Shot>& shots : of_tops) out.insert(out.end(), shots.begin(), shots.end());
    return out;
}

// Samples that the rays of a node leave, drawn by what they would send.
void GroupLight::aim(const Shot& shot, const Unoccluded& light, std::uint64_t seed,
                     std::vector<std::size_t>& samples) const {
    Random random(seed + ray_stream, shot.node);
    std::uint32_t at = shot.node;
    while (!groups_.nodes[at].is_leaf()) {
        const std::uint32_t child = groups_.nodes[at].child;
        at = child +
             (random.uniform() * static_cast<double>(light.power[at]) >= static_cast<double>(light.power[child]) &&
              light.power[child + 1] > 0.0f);
    }
    const std::size_t n = samples_.of_leaf;
    const float* kernel = light.kernels.data() + of_leaves_.number[at] * n;
    const double sum = std::accumulate(kernel, kernel + n, 0.0);
    const double offset = random.uniform();
    double up_to = static_cast<double>(kernel[0]);
    for (std::size_t k = 0, p = 0; k < shot.rays; ++k) {
        const double to = (static_cast<double>(k) + offset) / static_cast<double>(shot.rays) * sum;
        while ((up_to <= to || kernel[p] == 0.0f) && p + 1 < n) up_to += static_cast<double>(kernel[++p]);
        samples.push_back(of_leaves_.number[at] * n + p);
    }
}

std::vector<float> GroupLight::irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                          const GroupLightOptions& options) const {
    const Tracer& tracer = scene_.tracer();
    const Surfels& s = scene_.scene().surfels;
    std::vector<float> out(colors * groups_.size(), 0.0f);
    const auto emitters = emitters_of(lights);
    const NarrowLight narrow = has_disks_ && options.shares_narrow
                                   ? NarrowLight(scene_.scene(), lights, tracer, options.seed, {}, options.rays)
                                   : NarrowLight();
    for (const std::unique_ptr<Emitter>& light : emitters) {  // with the same random numbers: light is additive
        Unoccluded all;
        find_unoccluded(*light, narrow, reflectance, options.seed, all);
        const auto more = static_cast<double>(more_rays - 1) * wide_share(all);
        const std::vector<Shot> shots =
            plan(all, options.rays + static_cast<std::size_t>(more * static_cast<double>(options.rays)),
                 options.shares_across, options.seed);
        parallel_blocks(shots.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<std::size_t> samples;
            std::vector<Ray> rays;
            std::vector<char> free;
            for (std::size_t k = begin; k < end; ++k) aim(shots[k], all, options.seed, samples);
            for (const std::size_t p : samples) __builtin_prefetch(&s.normals[samples_.samples[p].surfel]);
            Random random(options.seed + end_stream, begin);
            for (const std::size_t p : samples) {
                Unoccluded::Met met{samples_.position(p), light->extended ? all.from[p] : all.from_all,
                                    samples_.samples[p].surfel};
                if (!all.is_wide.empty() && all.is_wide[p]) met.from = end_of(*light, p, random);
                if (const auto beam = all.beams.find(p / samples_.of_leaf); beam != all.beams.end()) met = beam->second;
                const Departure place{met.position, s.normals[met.surfel], met.surfel};
                rays.push_back(light->distant ? Ray{place, met.from} : segment(place, met.from));
            }
            tracer.free(rays, free);
            std::vector<std::uint32_t> below;
            for (std::size_t k = begin, r = 0; k < end; ++k) {
                float arrived = 0.0f;
                for (const std::size_t last = r + shots[k].rays; r < last; ++r) arrived += free[r] != 0 ? 1.0f : 0.0f;
                if (arrived == 0.0f) continue;
                const float share = shots[k].weight * arrived / static_cast<float>(shots[k].rays);
                for (below.assign(1, shots[k].node); !below.empty();) {
                    const std::uint32_t node = below.back();
                    below.pop_back();
                    if (!groups_.nodes[node].is_leaf()) {
                        below.push_back(groups_.nodes[node].child);
                        below.push_back(groups_.nodes[node].child + 1);
                        continue;
                    }
                    const float mean = share * all.means[of_leaves_.number[node]];
                    for (int c = 0; c < 3; ++c)
                        out[colors * node + static_cast<std::size_t>(c)] += mean * static_cast<float>(light->color[c]);
                }
            }
        });
        for (const auto& [leaf, mean] : all.shared)
            for (int c = 0; c < 3; ++c)
                out[colors * groups_.leaves[leaf] + static_cast<std::size_t>(c)] +=
                    static_cast<float>(mean * light->color[c]);
    }
    return out;
}

}  // namespace surflux
