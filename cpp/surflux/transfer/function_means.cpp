#include "surflux/transfer/function_means.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/meshless/receivers.h"

namespace surflux {

namespace {

// Functions of less than this, and less than so much of the largest of their level, are left to those of more.
constexpr double least_share = 0.0125, of_largest = 0.1;

// Of two passes that are one stage.
Progress half_of(const Progress& progress, std::size_t pass) {
    if (!progress) return {};
    return [&progress, pass](std::size_t done, std::size_t total) { return progress(pass * total + done, 2 * total); };
}

}  // namespace

SparseRows means_at_surfels(const SurfelMeans& means, const MultilevelBasis& basis,
                            const std::vector<std::uint32_t>& number, std::size_t surfels, const Progress& progress) {
    struct Share {
        std::uint32_t function;
        std::size_t level;
        double weight;
    };
    // Calls visit(surfel, shares) for all, in blocks side by side.
    const auto for_surfels = [&](const Progress& of_pass, const auto& visit) {
        parallel_blocks(
            surfels, 1024,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Share> shares;
                std::vector<double> all(basis.levels()), kept(basis.levels()), largest(basis.levels());
                for (std::size_t i = begin; i < end; ++i) {
                    shares.clear();
                    for (std::vector<double>* sums : {&all, &kept, &largest})
                        std::fill(sums->begin(), sums->end(), 0.0);
                    means.for_functions(i, [&](std::uint32_t j, double weight) {
                        if (number[j] == Receivers::none) return;
                        const std::size_t level = basis.level_of(j);
                        all[level] += weight;
                        largest[level] = std::max(largest[level], weight);
                        shares.push_back({number[j], level, weight});
                    });
                    const auto is_small = [&](const Share& share) {
                        return share.weight <= std::min(least_share, of_largest * largest[share.level]);
                    };
                    shares.erase(std::remove_if(shares.begin(), shares.end(), is_small), shares.end());
                    for (const Share& share : shares) kept[share.level] += share.weight;
                    for (Share& share : shares) share.weight *= all[share.level] / kept[share.level];
                    visit(i, shares);
                }
            },
            of_pass);
    };
    // Counted first, for there are many: an array that grows takes up to three times as much.
    SparseRows out;
    std::vector<std::uint32_t> counts(surfels);
    for_surfels(half_of(progress, 0), [&](std::size_t i, const std::vector<Share>& shares) {
        counts[i] = static_cast<std::uint32_t>(shares.size());
    });
    out.resize_rows(counts);
    for_surfels(half_of(progress, 1), [&](std::size_t i, const std::vector<Share>& shares) {
        SparseRows::Entry* to = out.entries.data() + out.begin[i];
        for (const Share& share : shares) *to++ = {share.function, static_cast<float>(share.weight)};
    });
    return out;
}

SparseRows means_at_groups(const SparseRows& at_surfels, const SenderGroups& senders, const std::vector<double>& areas,
                           const std::vector<double>& outside, std::uint32_t first, std::uint32_t last) {
    std::vector<std::vector<std::uint32_t>> members(senders.size());
    for (std::uint32_t i = 0; i < outside.size(); ++i)
        if (outside[i] > 0.0) members[senders.leaf_of_surfel[i]].push_back(i);
    std::vector<std::vector<SparseRows::Entry>> found(senders.leaves.size());
    parallel_for(senders.leaves.size(), 64, [&](std::size_t leaf) {
        std::vector<SparseRows::Entry> all;
        double area = 0.0;
        for (const std::uint32_t i : members[senders.leaves[leaf]]) {
            area += outside[i];
            const auto own = static_cast<float>(areas[i]);
            at_surfels.for_row(i, [&](std::uint32_t function, float weight) {
                if (function < first || function >= last) all.push_back({function, own * weight});
            });
        }
        std::stable_sort(all.begin(), all.end(),
                         [](const SparseRows::Entry& a, const SparseRows::Entry& b) { return a.column < b.column; });
        for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
            double sum = 0.0;
            for (; to < all.size() && all[to].column == all[from].column; ++to)
                sum += static_cast<double>(all[to].weight);
            found[leaf].push_back({all[from].column, static_cast<float>(sum / area)});
        }
    });
    SparseRows out;
    for (const std::vector<SparseRows::Entry>& row : found) {
        out.entries.insert(out.entries.end(), row.begin(), row.end());
        out.end_row();
    }
    return out;
}

}  // namespace surflux
