#include "surflux/meshless/surfel_means.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/inside.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 256;

}  // namespace

SurfelMeans::SurfelMeans(const Scene& scene, const Tracer& tracer, const SurfelPoints& points,
                         const MultilevelBasis& basis, const BasisSight& sight, const std::vector<double>& first_radius,
                         const Options& options, const Progress& progress)
    : scene_(scene),
      tracer_(tracer),
      points_(points),
      basis_(basis),
      sight_(sight),
      first_radius_(first_radius),
      options_(options),
      outside_(scene.surfels.size()) {
    for (std::uint32_t i = 0; i < outside_.size(); ++i)
        if (is_wide(i)) wide_.add(points_.area(i));
    const auto finest = static_cast<std::size_t>(options.levels - 1);
    std::vector<std::vector<PartlyInside>> found((outside_.size() + grain - 1) / grain);  // by blocks
    parallel_blocks(
        outside_.size(), grain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Departure> places, of_one;
            std::vector<std::size_t> first;
            for (std::size_t i = begin; i < end; ++i) {
                const auto index = static_cast<std::uint32_t>(i);
                first.push_back(places.size());
                places_on(index, std::min(all_places(), count_for(index, finest)), of_one);
                places.insert(places.end(), of_one.begin(), of_one.end());
            }
            first.push_back(places.size());
            const std::vector<char> inside =
                inside_geometry(scene_, tracer_, places, options_.seed + begin, options_.tuning);
            for (std::size_t i = begin; i < end; ++i) {
                const auto from = inside.begin() + static_cast<std::ptrdiff_t>(first[i - begin]),
                           to = inside.begin() + static_cast<std::ptrdiff_t>(first[i - begin + 1]);
                outside_[i] = std::find(from, to, 0) == to ? 0.0 : 1.0;
                if (outside_[i] == 0.0 || std::find(from, to, 1) == to) continue;
                const auto index = static_cast<std::uint32_t>(i);
                places_on(index, std::max(all_places(), count_for(index, finest)), of_one);
                PartlyInside part{index, inside_geometry(scene_, tracer_, of_one, options_.seed + i, options_.tuning)};
                const auto count = std::count(part.inside.begin(), part.inside.end(), 1);
                outside_[i] = 1.0 - static_cast<double>(count) / static_cast<double>(of_one.size());
                found[begin / grain].push_back(std::move(part));
            }
        },
        progress);
    for (std::vector<PartlyInside>& block : found)
        std::move(block.begin(), block.end(), std::back_inserter(partly_inside_));
}

// Which of its places are inside geometry; none: no place is, or all are.
const std::vector<char>* SurfelMeans::partly_inside(std::uint32_t i) const {
    const auto at =
        std::lower_bound(partly_inside_.begin(), partly_inside_.end(), i,
                         [](const PartlyInside& part, std::uint32_t surfel) { return part.surfel < surfel; });
    return at == partly_inside_.end() || at->surfel != i ? nullptr : &at->inside;
}

bool SurfelMeans::is_wide(std::uint32_t i) const {
    return points_.is_patch(i) && 2.0 * scene_.surfels.radii[i] > options_.widest * first_radius_[scene_.object[i]];
}

// How many places tell the mean over a surfel of what is about even over the spacing of a level.
int SurfelMeans::count_for(std::uint32_t i, std::size_t level) const {
    const double spacing = std::ldexp(first_radius_[scene_.object[i]], -static_cast<int>(level));
    const double across = 2.0 * scene_.surfels.radii[i] / std::max(1e-300, spacing);
    int count = 1;
    if (is_wide(i)) {
        if (!(spacing > 0.0)) return all_places();
        const double area = points_.area(i),
                     most = std::max(1.0 * all_places(), options_.tuning.places_on_wide * wide_.share(area));
        return static_cast<int>(
            std::clamp(options_.tuning.places_in_cell * area / (spacing * spacing), 1.0 * all_places(), most));
    }
    if (points_.is_patch(i))
        while (count < options_.tuning.most_places && count < across * across) count *= 4;
    return count;
}

// The centre, or many all over a patch; the first of many are the same.
void SurfelMeans::places_on(std::uint32_t i, int count, std::vector<Departure>& out) const {
    const Surfels& s = scene_.surfels;
    EvenPoints points(2, options_.seed, i);
    out.clear();
    for (int p = 0; p < count; ++p) {
        const double* u = points.next();
        out.push_back({count == 1 ? s.positions[i] : points_.at(i, u[0], u[1]), s.normals[i], i});
    }
}

void SurfelMeans::outside_places(std::uint32_t i, std::vector<Departure>& out) const {
    out.clear();
    if (outside_[i] == 0.0) return;
    const std::vector<char>* inside = partly_inside(i);
    std::vector<Departure> places;
    places_on(i, count_for(i, 0), places);
    for (std::size_t p = 0; p < places.size(); ++p)
        if (!inside || (*inside)[p] == 0) out.push_back(places[p]);
}

void SurfelMeans::at_level(std::size_t level, std::uint32_t i, const Vec3& point, std::vector<BasisWeight>& out) const {
    const std::uint32_t object = scene_.object[i];
    if (outside_[i] == 0.0) return basis_.at_level(level, point, scene_.surfels.normals[i], object, out);
    const auto begin = levels_[level].entries.begin() + static_cast<std::ptrdiff_t>(levels_[level].begin[i]),
               end = levels_[level].entries.begin() + static_cast<std::ptrdiff_t>(levels_[level].begin[i + 1]);
    basis_.weights(level, point, scene_.surfels.normals[i], object, out);
    const auto foreign = [&](const BasisWeight& w) {
        const auto at = std::lower_bound(begin, end, w.function,
                                         [](const Entry& e, std::uint32_t function) { return e.function < function; });
        return at == end || at->function != w.function;
    };
    out.erase(std::remove_if(out.begin(), out.end(), foreign), out.end());
    if (is_wide(i)) sight_.keep_seen_if_parted(point, scene_.surfels.normals[i], out);
    basis_.to_shares(level, object, out);
    if (!out.empty() || !basis_.is_coarsest(level, object)) return;
    if (is_wide(i) && sight_.is_dark(point, scene_.surfels.normals[i], first_radius_[object])) return;
    for (auto at = begin; at != end; ++at) out.push_back({at->function, static_cast<double>(at->weight) / outside_[i]});
}

void SurfelMeans::extend(std::size_t spacing_level, const Progress& progress) {
    const std::size_t n = outside_.size(), level = basis_.levels() - 1;
    std::vector<std::vector<Entry>> found((n + grain - 1) / grain);  // by blocks
    Rows rows;
    rows.begin.assign(n + 1, 0);
    parallel_blocks(
        n, grain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Entry>& out = found[begin / grain];
            std::vector<Departure> places;
            std::vector<BasisWeight> weights, all;
            for (std::size_t k = begin; k < end; ++k) {
                if (outside_[k] == 0.0) continue;
                const auto i = static_cast<std::uint32_t>(k);
                const std::uint32_t object = scene_.object[k];
                const std::vector<char>* inside = partly_inside(i);
                const int count = count_for(i, spacing_level);
                places_on(i, inside ? std::max(all_places(), count) : count, places);
                all.clear();
                // A place that sees none of the coarsest has what others of the surfel have, but where it is dark.
                const bool wide = is_wide(i);
                const bool coarsest = basis_.is_coarsest(level, object);
                std::size_t seen = 0;
                for (std::size_t p = 0; p < places.size(); ++p) {
                    if (inside && (*inside)[p] != 0) continue;
                    sight_.at_level(level, places[p].position, places[p].normal, object, i, weights);
                    all.insert(all.end(), weights.begin(), weights.end());
                    seen += !coarsest || !weights.empty() ||
                            (wide && sight_.is_dark(places[p].position, places[p].normal, first_radius_[object]));
                }
                std::sort(all.begin(), all.end(),
                          [](const BasisWeight& a, const BasisWeight& b) { return a.function < b.function; });
                const std::size_t before = out.size();
                const double share = outside_[k] / static_cast<double>(seen);
                for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
                    double sum = 0.0;
                    for (; to < all.size() && all[to].function == all[from].function; ++to) sum += all[to].weight;
                    out.push_back({all[from].function, static_cast<float>(share * sum)});
                }
                rows.begin[k + 1] = static_cast<std::uint32_t>(out.size() - before);
            }
        },
        progress);
    std::size_t weights = 0;
    for (const std::vector<Entry>& block : found) weights += block.size();
    require(weights <= std::numeric_limits<std::uint32_t>::max(), "radius: a level of the basis has ", weights,
            " weights at surfels, more than 2^32; wanted larger ones, or fewer surfels");
    for (std::size_t i = 0; i < n; ++i) rows.begin[i + 1] += rows.begin[i];
    rows.entries.reserve(rows.begin[n]);
    for (std::vector<Entry>& block : found) {
        rows.entries.insert(rows.entries.end(), block.begin(), block.end());
        std::vector<Entry>().swap(block);
    }
    levels_.push_back(std::move(rows));
}

}  // namespace surflux
