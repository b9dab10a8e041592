#include "surflux/transfer/operator_arrays.h"

#include <cmath>
#include <vector>

#include "surflux/core/error.h"

namespace surflux {

namespace {

template <class... Numbers>
bool all_finite(Numbers... numbers) {
    return (std::isfinite(numbers) && ...);
}

void require_finite(const char* name, const std::vector<Vec3>& values) {
    for (const Vec3& value : values) require(is_finite(value), name, ": wanted finite numbers");
}

void require_below(const char* name, const std::vector<std::uint32_t>& indices, std::size_t count) {
    for (const std::uint32_t index : indices) require(index < count, name, ": wanted indices below ", count);
}

// Where each of `count` rows begins among so many entries, and the end.
void require_begins(const char* name, const std::vector<std::uint32_t>& begin, std::size_t count, std::size_t entries) {
    require(begin.size() == count + 1 && begin.front() == 0 && begin.back() == entries, name, ": wanted where each of ",
            count, " rows begins");
    for (std::size_t k = 1; k < begin.size(); ++k)
        require(begin[k] >= begin[k - 1], name, ": wanted ascending numbers");
}

void require_rows(const char* begin, const char* name, const SparseRows& rows, std::size_t count, std::size_t columns) {
    require_begins(begin, rows.begin, count, rows.entries.size());
    for (const SparseRows::Entry& entry : rows.entries)
        require(entry.column < columns && all_finite(entry.weight), name, ": wanted columns below ", columns,
                " and finite weights");
}

void require_receivers(const TransportOperator& of, std::size_t surfels) {
    const std::size_t n = of.rows.size();
    require(of.positions.size() == n && of.normals.size() == n && of.surfels.size() == n, "positions: wanted those of ",
            n, " rows");
    require_finite("positions", of.positions);
    require_finite("normals", of.normals);
    require_below("surfels", of.surfels, surfels);
    for (const TransportOperator::Row& row : of.rows)
        require(row.begin <= row.end && row.end <= of.links.size() && all_finite(row.per_ray, row.u, row.v),
                "rows: wanted rows of links and finite numbers");
    for (const TransportOperator::Row& row : of.rows)  // each may be rounded up
        require(static_cast<float>(row.escape + row.into_backs) <= ShotRows::share_scale + 1.0f,
                "rows: wanted shares that escape and that backs absorb of at most 1 together");
    for (const TransportOperator::Link link : of.links)
        require(TransportOperator::sender(link) < of.senders.size(), "links: wanted senders below ", of.senders.size());
    require(of.slopes.size() == of.links.size(), "slopes: wanted those of ", of.links.size(), " links");
}

void require_functions(const TransportOperator& of, std::size_t surfels) {
    const std::size_t functions = of.receiver_of.size();
    require_below("receiver_of", of.receiver_of, of.rows.size());
    require(of.level_begin.size() >= 2, "level_begin: wanted levels");
    require_begins("level_begin", of.level_begin, of.level_begin.size() - 1, functions);
    require_rows("parents_begin", "parents", of.parents, functions, functions);
    for (std::size_t level = 0; level + 1 < of.level_begin.size(); ++level)
        for (std::uint32_t p = of.parents.begin[of.level_begin[level]]; p < of.parents.begin[of.level_begin[level + 1]];
             ++p)
            require(of.parents.entries[p].column < of.level_begin[level],
                    "parents: wanted functions of coarser levels");
    const std::uint32_t own = of.level_begin.back() - of.level_begin[of.own_level()];
    require(own <= of.rows.size(), "level_begin: wanted a row for each cluster of surfels that has its own");
    require_rows("at_groups_begin", "at_groups", of.at_groups, of.senders.leaves.size(), functions);
    require_rows("at_surfels_begin", "at_surfels", of.at_surfels, surfels, functions);
}

void require_senders(const SenderGroups& senders, std::size_t surfels) {
    const std::size_t n = senders.size();
    for (std::size_t k = 0; k < n; ++k) {
        const SenderGroups::Node& node = senders.nodes[k];
        require(node.parent == SenderGroups::none || node.parent < k, "nodes: wanted parents before their children");
        require(node.is_leaf() || (node.child > k && node.child < n - 1),
                "nodes: wanted children behind their parents");
        require(node.is_leaf() || (senders.nodes[node.child].parent == k && senders.nodes[node.child + 1].parent == k),
                "nodes: wanted children of one parent");
        require((node.parent == SenderGroups::none) == (k == 0), "nodes: wanted one root");
        require(all_finite(node.area, node.radius, node.alike, node.weight), "nodes: wanted finite numbers");
    }
    require_below("leaves", senders.leaves, n);
    std::vector<char> is_told(n, 0);
    for (const std::uint32_t leaf : senders.leaves) {
        require(senders.nodes[leaf].is_leaf() && !is_told[leaf], "leaves: wanted nodes without children, once each");
        is_told[leaf] = 1;
    }
    require(senders.leaf_of_surfel.size() == surfels, "leaf_of_surfel: wanted those of ", surfels, " surfels");
    require_below("leaf_of_surfel", senders.leaf_of_surfel, n);
}

void require_samples(const SenderSamples& samples, std::size_t leaves, std::size_t surfels) {
    const std::size_t n = samples.samples.size();
    require(leaves == 0 ? n == 0 : n % leaves == 0 && n / leaves == samples.of_leaf, "samples: wanted ",
            samples.of_leaf, " for each of ", leaves, " leaves");
    require(samples.origin.size() == 1, "sample_origin: wanted one place");
    require_finite("sample_origin", samples.origin);
    for (const SenderSamples::Sample& sample : samples.samples) {
        require(all_finite(sample.x, sample.y, sample.z, sample.normal_x, sample.normal_y, sample.normal_z),
                "samples: wanted finite numbers");
        require(sample.surfel < surfels, "samples: wanted surfels below ", surfels);
    }
}

}  // namespace

void require_whole(const TransportOperator& of, std::size_t surfels) {
    require_senders(of.senders, surfels);
    require_samples(of.samples, of.senders.leaves.size(), surfels);
    require_receivers(of, surfels);
    require_functions(of, surfels);
    require(of.areas.size() == surfels, "areas: wanted those of ", surfels, " surfels");
    for (const double area : of.areas) require(all_finite(area) && area >= 0.0, "areas: wanted finite numbers");
}

}  // namespace surflux
