#include "surflux/meshless/basis_sight.h"

#include <algorithm>
#include <array>
#include <map>

#include "surflux/core/parallel.h"

namespace surflux {

BasisSight::BasisSight(const Scene& scene, const Tracer& tracer, const MultilevelBasis& basis,
                       const MeshlessTuning& tuning)
    : scene_(scene), basis_(basis), sight_(tracer, scene), most_tries_(whole_number(tuning.anchor_tries)) {
    const std::vector<std::uint32_t> triangles = triangle_ranges(scene.surfels);
    for (std::size_t i = 0; i < scene.object.size(); ++i) {
        const std::uint32_t object = scene.object[i];
        if (object >= is_cloud_.size()) is_cloud_.resize(object + 1, 1);
        if (triangles[i] < triangles[i + 1]) is_cloud_[object] = 0;
    }
}

void BasisSight::clear() {
    surfel_.clear();
    places_.clear();
    pairs_.clear();
}

void BasisSight::extend(const std::vector<std::uint32_t>& surfels, const Progress& progress) {
    const std::size_t before = places_.size();
    surfel_.insert(surfel_.end(), surfels.begin(), surfels.end());
    surfel_.resize(basis_.size(), Hit::none);
    places_.resize(basis_.size());
    parallel_blocks(
        basis_.size() - before, 256,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = before + begin; k < before + end; ++k) {
                const auto j = static_cast<std::uint32_t>(k);
                const Vec3 &at = basis_.position(j), &normal = basis_.normal(j);
                places_[k] = {at, normal, sight_.headroom(at, normal)};
            }
        },
        progress);
    for (std::size_t level = pairs_.size(); level < basis_.levels(); ++level)
        pairs_.emplace_back(new Pairs[basis_.first(level + 1) - basis_.first(level)]);
}

bool BasisSight::joined(std::uint32_t a, std::uint32_t b) const {
    if (a == b) return true;
    if (a > b) std::swap(a, b);
    const std::size_t level = basis_.level_of(a);
    const std::uint32_t key = 2 * (b - basis_.first(level) + 1);
    std::atomic<std::uint32_t>(&known)[room] = pairs_[level][a - basis_.first(level)].of;
    std::size_t k = 0;
    for (; k < room; ++k) {
        const std::uint32_t at = known[k].load(std::memory_order_relaxed);
        if (at == 0) break;
        if ((at & ~1u) == key) return (at & 1u) != 0;
    }
    const bool answer = sight_.joined(places_[a], places_[b]);
    for (; k < room; ++k) {
        std::uint32_t free = 0;
        if (known[k].compare_exchange_strong(free, key + answer, std::memory_order_relaxed) || (free & ~1u) == key)
            break;
    }
    return answer;
}

void BasisSight::keep_seen(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& weights) const {
    double above = -1.0;
    const auto sees = [&](const BasisWeight& w) { return sight_.sees(point, normal, above, places_[w.function]); };
    const auto heavier = [](const BasisWeight& a, const BasisWeight& b) {
        return a.weight > b.weight || (a.weight == b.weight && a.function < b.function);
    };
    const auto last = weights.begin() + static_cast<std::ptrdiff_t>(std::min(most_tries_, weights.size()));
    auto anchor = weights.begin();
    for (; anchor != last; ++anchor) {
        std::iter_swap(anchor, std::min_element(anchor, weights.end(), heavier));
        if (sees(*anchor)) break;
    }
    if (anchor == last) return weights.clear();
    weights.erase(weights.begin(), anchor);
    const std::uint32_t seen = weights[0].function;
    const auto parted = [&](const BasisWeight& w) {
        return !joined(seen, w.function) && !sight_.overlooks(point, normal, places_[w.function]);
    };
    weights.erase(std::remove_if(weights.begin() + 1, weights.end(), parted), weights.end());
}

void BasisSight::at_level(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                          std::uint32_t surfel, std::vector<BasisWeight>& out) const {
    if (is_cloud_[object]) return basis_.at_level(level, point, normal, object, out);
    if (const std::uint32_t in = surfel == Hit::none ? no_nook : nook(surfel); in != no_nook) {
        out.clear();
        if (level == basis_.level_of(in)) out.push_back({in, 1.0});
        return;
    }
    basis_.weights(level, point, normal, object, out);
    keep_seen(point, normal, out);
    basis_.to_shares(level, object, out);
}

void BasisSight::keep_seen_if_parted(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& weights) const {
    const auto apart = [&](const BasisWeight& w) { return !joined(weights[0].function, w.function); };
    if (std::any_of(weights.begin(), weights.end(), apart)) keep_seen(point, normal, weights);
}

std::vector<std::vector<std::uint32_t>> BasisSight::nooks(const std::vector<Departure>& asked,
                                                          const std::vector<double>& spacing,
                                                          const Progress& progress) const {
    std::vector<char> hidden(asked.size(), 0);
    const auto object_of = [&](const Departure& place) { return scene_.object[place.surfel]; };
    parallel_blocks(
        asked.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<BasisWeight> near;
            for (std::size_t k = begin; k < end; ++k) {
                at_level(0, asked[k].position, asked[k].normal, object_of(asked[k]), Hit::none, near);
                hidden[k] = near.empty();
            }
        },
        progress);
    struct Nook {
        Sight::Place first;
        std::size_t index;
    };
    std::map<std::array<std::int64_t, 4>, std::vector<Nook>> cells;  // by object, and cubes of its spacing
    const Vec3 low = bounds_of(scene_.surfels).low;
    std::vector<std::vector<std::uint32_t>> out;
    for (std::uint32_t i = 0; i < asked.size(); ++i) {
        if (!hidden[i]) continue;
        const Vec3 &place = asked[i].position, &normal = asked[i].normal;
        const double side = spacing[object_of(asked[i])];
        const Vec3 at = (1.0 / side) * (place - low);
        const std::array<std::int64_t, 4> cell{object_of(asked[i]), static_cast<std::int64_t>(at.x),
                                               static_cast<std::int64_t>(at.y), static_cast<std::int64_t>(at.z)};
        double above = -1.0;
        const Nook* in = nullptr;
        std::size_t tries = 0;
        for (std::int64_t k = 0; k < 27 && !in; ++k) {
            // From the middle one on.
            const std::int64_t at_k = (k + 13) % 27, x = at_k % 3 - 1, y = at_k / 3 % 3 - 1, z = at_k / 9 - 1;
            const auto near = cells.find({cell[0], cell[1] + x, cell[2] + y, cell[3] + z});
            if (near == cells.end()) continue;
            for (std::size_t n = near->second.size(); n-- > 0 && tries < most_tries_;) {
                const Nook& nook = near->second[n];
                if (!(length(nook.first.position - place) < side * dot(nook.first.normal, normal))) continue;
                ++tries;
                if (!sight_.sees(place, normal, above, nook.first)) continue;
                in = &nook;
                break;
            }
        }
        if (in) {
            out[in->index].push_back(i);
            continue;
        }
        if (above < 0.0) above = sight_.headroom(place, normal);
        cells[cell].push_back({{place, normal, above}, out.size()});
        out.push_back({i});
    }
    return out;
}

void BasisSight::set_nook(const std::vector<std::uint32_t>& surfels, std::uint32_t function) {
    nook_.resize(scene_.surfels.size(), no_nook);
    for (const std::uint32_t i : surfels) nook_[i] = function;
}

}  // namespace surflux
