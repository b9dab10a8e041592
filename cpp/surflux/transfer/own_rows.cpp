#include "surflux/transfer/own_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

#include "surflux/core/bisection.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/receivers.h"

namespace surflux {

namespace {

constexpr std::size_t batch = 8192;    // surfels that are asked at once
constexpr double normal_weight = 1.5;  // as Bisection has it: the two sides of a sheet part first

struct Part {
    std::size_t first, last;
    double excess;  // of what members differ by, over what is allowed
};

class Clusters {
public:
    Clusters(const Scene& scene, const std::vector<double>& areas, const ContradictedSurfels& of, const RowTest& test,
             double epsilon)
        : scene_(scene),
          areas_(areas),
          of_(of),
          test_(test),
          allowed_(epsilon * epsilon),
          halving_(of.surfels.size(), normal_weight) {}

    std::vector<Part> part(std::size_t most, const Progress& progress) {
        const auto less = [](const Part& a, const Part& b) {
            return a.excess < b.excess || (a.excess == b.excess && a.first > b.first);
        };
        std::priority_queue<Part, std::vector<Part>, decltype(less)> open(less);
        const auto place = [&](std::uint32_t k) {
            const std::uint32_t i = of_.surfels[k];
            return PlaceAndNormal{scene_.surfels.positions[i], scene_.surfels.normals[i]};
        };
        if (!of_.surfels.empty() && most > 0) open.push(describe(0, of_.surfels.size()));
        while (!open.empty() && open.size() < most && open.top().excess > 0.0) {
            report_some(progress, open.size(), most, 64);
            const Part top = open.top();
            open.pop();
            const std::size_t middle = halving_.halve(top.first, top.last, place);
            open.push(describe(top.first, middle));
            open.push(describe(middle, top.last));
        }
        std::vector<Part> out;
        for (; !open.empty(); open.pop()) out.push_back(open.top());
        std::sort(out.begin(), out.end(), [](const Part& a, const Part& b) { return a.first < b.first; });
        return out;
    }

    Cluster cluster(const Part& part) const {
        Cluster out;
        Vec3 mean;
        double area = 0.0;
        for (std::size_t k = part.first; k < part.last; ++k) {
            const std::uint32_t i = of_.surfels[halving_.order[k]];
            mean += areas_[i] * scene_.surfels.positions[i];
            area += areas_[i];
            out.members.push_back(halving_.order[k]);
        }
        mean = mean / area;
        out.middle = of_.surfels[*std::min_element(
            out.members.begin(), out.members.end(), [&](std::uint32_t a, std::uint32_t b) {
                const double far_a = length_squared(scene_.surfels.positions[of_.surfels[a]] - mean),
                             far_b = length_squared(scene_.surfels.positions[of_.surfels[b]] - mean);
                return far_a < far_b || (far_a == far_b && a < b);
            })];
        return out;
    }

private:
    // The variance of the rays is no difference.
    Part describe(std::size_t first, std::size_t last) const {
        if (last - first < 2) return {first, last, 0.0};
        const std::size_t n = test_.size();
        std::vector<double> mean(n, 0.0);
        double area = 0.0, variance = 0.0;
        for (std::size_t k = first; k < last; ++k) {
            const std::uint32_t j = halving_.order[k];
            const double own = areas_[of_.surfels[j]];
            area += own;
            variance += own * static_cast<double>(of_.variance[j]);
            const float* values = of_.received.data() + j * n;
            for (std::size_t c = 0; c < n; ++c) mean[c] += own * static_cast<double>(values[c]);
        }
        std::vector<float> difference(n);
        double spread = 0.0;
        for (std::size_t k = first; k < last; ++k) {
            const std::uint32_t j = halving_.order[k];
            const float* values = of_.received.data() + j * n;
            for (std::size_t c = 0; c < n; ++c) difference[c] = values[c] - static_cast<float>(mean[c] / area);
            spread += areas_[of_.surfels[j]] * test_.mean_square(difference.data());
        }
        return {first, last, std::max(0.0, spread - variance - allowed_ * area)};
    }

    const Scene& scene_;
    const std::vector<double>& areas_;
    const ContradictedSurfels& of_;
    const RowTest& test_;
    double allowed_;
    Bisection halving_;
};

}  // namespace

ContradictedSurfels find_contradicted(const std::vector<Place>& places, const std::vector<double>& areas,
                                      const RowShooter& shooter, const RowTest& test, const SparseRows& at_surfels,
                                      const std::vector<float>& coefs, const OwnRowOptions& options,
                                      const Progress& progress, const Team& team) {
    const std::size_t n = places.size(), channels = test.size();
    const auto ask = [&](std::size_t first, std::size_t last) {
        ContradictedSurfels out;
        report(progress, first, n);
        std::vector<Place> asked;
        for (std::size_t i = first; i < last; ++i)
            if (areas[i] > 0.0) asked.push_back(places[i]);
        ShotRows rows;
        shooter.add(asked, std::vector<int>(asked.size(), options.check_rays), rows, {});
        RowTest::Received received;
        test.receive(rows, received);
        std::vector<double> square(asked.size(), 0.0);  // 0 where the basis is not off
        parallel_for(asked.size(), 64, [&](std::size_t k) {
            const float* values = received.values.data() + k * channels;
            std::vector<float> difference(values, values + channels);
            at_surfels.for_row(asked[k].surfel, [&](std::uint32_t function, float weight) {
                const float* by_basis = coefs.data() + function * channels;
                for (std::size_t c = 0; c < channels; ++c) difference[c] -= weight * by_basis[c];
            });
            if (test.is_off(values, difference.data(), options.epsilon, received.variance[k]))
                square[k] = test.mean_square(difference.data());
        });
        for (std::size_t k = 0; k < asked.size(); ++k) {
            const std::uint32_t i = asked[k].surfel;
            if (square[k] == 0.0) continue;
            out.surfels.push_back(i);
            out.variance.push_back(received.variance[k]);
            out.error.push_back(areas[i] * (square[k] - static_cast<double>(received.variance[k])));
            const float* values = received.values.data() + k * channels;
            out.received.insert(out.received.end(), values, values + channels);
        }
        return out;
    };
    std::vector<ContradictedSurfels> parts((n + batch - 1) / batch);
    const auto make = [&] {
        for_own_blocks(team, n, batch,
                       [&](std::size_t first, std::size_t last) { parts[first / batch] = ask(first, last); });
    };
    if (team.shares())
        exchange_blocks(
            team, "contradictions", digest_of(coefs), n, batch, make,
            [&](std::size_t first, std::size_t, Packed& to) {
                parts[first / batch].for_each([&](const auto& values) { to.add(values); });
            },
            [&](std::size_t first, std::size_t, Unpacking& from) {
                parts[first / batch].for_each([&](auto& values) {
                    values.clear();
                    from.append_to(values);
                });
            });
    else
        make();
    ContradictedSurfels all;
    for (ContradictedSurfels& part : parts) {
        all.append(part);
        part = {};  // it takes much memory
    }
    return all;
}

std::vector<Cluster> cluster_alike(const Scene& scene, const std::vector<double>& areas,
                                   const ContradictedSurfels& contradicted, const RowTest& test,
                                   const OwnRowOptions& options, const Progress& progress) {
    Clusters clusters(scene, areas, contradicted, test, options.epsilon);
    std::vector<Cluster> out;
    for (const Part& part : clusters.part(options.most, progress)) out.push_back(clusters.cluster(part));
    return out;
}

bool is_better(const RowTest& test, const RowTest::Received& received, std::size_t row,
               const ContradictedSurfels& contradicted, std::size_t member, double area) {
    const std::size_t n = test.size();
    std::vector<float> difference(n);
    for (std::size_t c = 0; c < n; ++c)
        difference[c] = contradicted.received[member * n + c] - received.values[row * n + c];
    const double square = test.mean_square(difference.data()) -
                          static_cast<double>(contradicted.variance[member] + received.variance[row]);
    return square * area < contradicted.error[member];
}

std::vector<Cluster> patch_nooks(const BasisSight& sight, const SurfelPoints& points, const std::vector<double>& areas,
                                 std::size_t most) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> found;  // patches of each function
    for (std::uint32_t i = 0; i < areas.size(); ++i) {
        const std::uint32_t function = sight.nook(i);
        if (function != BasisSight::no_nook && points.is_patch(i) && areas[i] > 0.0) found[function].push_back(i);
    }
    const auto wider = [&](std::uint32_t a, std::uint32_t b) {
        return areas[a] > areas[b] || (areas[a] == areas[b] && a < b);
    };
    std::vector<std::uint32_t> others;
    for (auto& [function, members] : found) {
        std::iter_swap(members.begin(), std::min_element(members.begin(), members.end(), wider));
        others.insert(others.end(), members.begin() + 1, members.end());
    }
    std::sort(others.begin(), others.end(), wider);
    if (others.size() > most - std::min(most, found.size())) others.resize(most - std::min(most, found.size()));
    std::vector<Cluster> out;
    for (const std::uint32_t i : others) out.push_back({i, {i}});
    std::sort(others.begin(), others.end());
    for (auto& [function, members] : found) {
        const auto has_own = [&](std::uint32_t i) { return std::binary_search(others.begin(), others.end(), i); };
        members.erase(std::remove_if(members.begin(), members.end(), has_own), members.end());
        out.push_back({members[0], members});
    }
    std::sort(out.begin(), out.end(), [&](const auto& a, const auto& b) { return wider(a.middle, b.middle); });
    return out;
}

void give_own_functions(const std::vector<SparseRows::Entry>& own, SparseRows& at_surfels) {
    std::vector<std::uint32_t> counts(own.size());
    bool any = false;
    for (std::size_t i = 0; i < own.size(); ++i) {
        const bool is_own = own[i].column != Receivers::none;
        counts[i] = is_own ? 1 : at_surfels.begin[i + 1] - at_surfels.begin[i];
        any = any || is_own;
    }
    if (!any) return;
    SparseRows all;
    all.resize_rows(counts);
    for (std::size_t i = 0; i < own.size(); ++i)
        if (own[i].column != Receivers::none)
            all.entries[all.begin[i]] = own[i];
        else
            std::copy_n(at_surfels.entries.data() + at_surfels.begin[i], counts[i], all.entries.data() + all.begin[i]);
    at_surfels = std::move(all);
}

}  // namespace surflux
