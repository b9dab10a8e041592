#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/placed_basis.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/refined_region.h"
#include "surflux/scene/extent.h"
#include "surflux/solution/stopwatch.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/function_means.h"
#include "surflux/transfer/group_oracle.h"
#include "surflux/transfer/operator_memory.h"
#include "surflux/transfer/own_rows.h"
#include "surflux/transfer/pack_rows.h"
#include "surflux/transfer/places_in_air.h"
#include "surflux/transfer/row_shooter.h"
#include "surflux/transfer/sky_irradiance.h"
#include "surflux/transfer/sky_visibility.h"
#include "surflux/transfer/test_lights.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

namespace {

constexpr int least_rays = static_cast<int>(MeshlessTuning{}.least_rays);
constexpr int check_rays = 128;           // that tell whether the basis is off at a surfel
constexpr double most_own = 0.25;         // rows of such surfels, of as many as receivers have
constexpr double little_sky = 0.5;        // RMS over the sphere: of what scenes see that see less, errors are shares
constexpr std::size_t bounce_levels = 3;  // that lamps' light is reflected again by
constexpr std::uint64_t sample_stream = 0x5e17, lamp_stream = 0x1a3b, check_stream = 0x2c4d, own_stream = 0x3d5e,
                        sky_stream = 0x4e6f, group_stream = 0x5f80;

class OperatorBuilder {
public:
    OperatorBuilder(const CompiledScene& compiled, const OperatorOptions& options, const StageProgress& progress,
                    Figures& timings)
        : compiled_(compiled),
          scene_(compiled.scene()),
          options_(options),
          max_memory_(options.max_memory > 0.0 ? options.max_memory : 0.75 * available_to_all(options.team)),
          progress_(progress),
          watch_(timings),
          tracer_(compiled.tracer(stage("trace"))),
          points_(scene_.surfels),
          placed_(scene_, tracer_, points_, basis_,
                  {options.radius, options.levels, MeshlessTuning{}.widest_mean, options.seed}, stage("placement")),
          receivers_(basis_, placed_.sight()) {
        for (std::size_t i = 0; i < scene_.surfels.size(); ++i)
            out_.areas.push_back(scene_.surfels.areas[i] * placed_.means().outside(i));
        watch_.lap("placement");
    }

    TransportOperator run() {
        placed_.add_first(stage("placement"));
        receivers_.resize();
        const std::vector<std::uint32_t> first = receivers_.add(all_of_level(0), stage("placement"));
        watch_.lap("placement");
        find_free_paths(first);
        group_senders();
        memory_with(ray_counts(first)).require_room(max_memory_);
        shoot(first);
        make_test();
        for (int level = 1; level < options_.levels; ++level) {
            const std::vector<std::uint32_t> refined = to_refine(static_cast<std::size_t>(level - 1));
            if (refined.empty()) break;
            placed_.add_around(refined, stage("placement"));
            receivers_.resize();
            watch_.lap("placement");
            const std::vector<std::uint32_t> children = children_of(basis_, refined);
            if (children.empty()) break;
            if (!memory_with(ray_counts(children)).fits(max_memory_)) {
                out_.left_out = refined.size();
                break;
            }
            shoot(receivers_.add(children, stage("gathering")));
            test();
        }
        for (int k = 0; k < MeshlessTuning{}.repeats; ++k) repeat();
        number_functions();
        out_.at_surfels =
            means_at_surfels(placed_.means(), basis_, number_, scene_.surfels.size(), stage("projection"));
        placed_.forget_weights();
        watch_.lap("projection");
        give_rows_to_surfels();
        pack_rows(std::move(shot_), order_, out_);
        watch_.lap("surfels");
        if (options_.lighting == OperatorOptions::Lighting::local) {
            out_.bounce_levels = bounce_levels;
        } else {  // no lamp is seen from samples
            out_.samples.samples = {};
            out_.samples.of_leaf = 0;
        }
        out_.at_groups = means_at_groups(out_.at_surfels, out_.senders, scene_.surfels.areas, out_.areas,
                                         out_.level_begin[out_.bounce_end()], out_.level_begin[out_.own_level()]);
        watch_.lap("projection");
        return std::move(out_);
    }

private:
    Progress stage(const char* name) const { return progress_ ? progress_(name) : Progress{}; }

    std::vector<std::uint32_t> all_of_level(std::size_t level) const {
        std::vector<std::uint32_t> out(basis_.first(level + 1) - basis_.first(level));
        std::iota(out.begin(), out.end(), basis_.first(level));
        return out;
    }
    Place place_of(std::uint32_t j) const {
        return {basis_.position(j), basis_.normal(j), placed_.sight().surfel(j), Place::point};
    }

    // From receivers, and from surfels: pi times the mean length of rays, over the volume of the air, is the mean
    // irradiance from a lamp that may be anywhere in it.
    void find_free_paths(const std::vector<std::uint32_t>& receivers) {
        std::vector<Place> places;
        for (const std::uint32_t j : receivers) places.push_back(place_of(j));
        const bool of_lamps = options_.lighting == OperatorOptions::Lighting::local;
        const std::vector<double> found =
            free_paths(points_, tracer_, places, of_lamps, options_.seed + lamp_stream, stage("grouping"));
        free_path_.resize(receivers.size());
        for (std::size_t k = 0; k < found.size(); ++k) free_path_[receivers_.row(receivers[k])] = found[k];
    }

    void group_senders() {
        std::vector<double> of_function, of_surfel;
        receivers_.coefficients(free_path_, of_function);
        for (std::size_t i = 0; i < scene_.surfels.size(); ++i) {
            double path = 0.0;
            placed_.means().for_functions(i, [&](std::uint32_t j, double weight) { path += weight * of_function[j]; });
            of_surfel.push_back(std::max(0.0, path));
        }
        const bool of_lamps = options_.lighting == OperatorOptions::Lighting::local;
        const GroupOracle oracle(scene_.surfels, points_, tracer_, !of_lamps, options_.seed + group_stream, of_surfel);
        const auto unlikeness = [&](const std::uint32_t* members, std::size_t count, std::uint64_t stream) {
            return oracle.unlikeness(members, count, stream);
        };
        require(options_.senders <= TransportOperator::most_senders / 2, "senders: wanted at most ",
                TransportOperator::most_senders / 2, ", got ", options_.senders);
        out_.senders = SenderGroups(scene_, out_.areas, of_surfel, options_.senders, unlikeness, oracle.walls(of_lamps),
                                    stage("grouping"));
        out_.samples =
            sample_senders(scene_, points_, out_.areas, out_.senders, options_.samples, options_.seed + sample_stream);
        watch_.lap("grouping");
    }

    std::vector<int> ray_counts(const std::vector<std::uint32_t>& receivers) const {
        const int least = std::min(options_.rays, least_rays);
        std::vector<int> out;
        for (const std::uint32_t j : receivers)
            out.push_back(placed_.is_in_nook(j) ? least : std::max(least, options_.rays >> (basis_.level_of(j) / 2)));
        return out;
    }
    std::size_t test_size() const {
        return options_.lighting == OperatorOptions::Lighting::local ? TestLights::sums
                                                                     : SphericalHarmonics::count(VisibilityTest::order);
    }
    // When more receivers have shot so many rays each.
    OperatorMemory memory_with(const std::vector<int>& rays) const {
        return {scene_.surfels.size(), placed_.means().weights(), test_size(), out_.senders.size(), shot_, rays};
    }

    // Rows of receivers that have none, in the order in which these are numbered.
    void shoot(const std::vector<std::uint32_t>& fresh) {
        std::vector<Place> places;
        for (const std::uint32_t j : fresh) places.push_back(place_of(j));
        const RowShooter shooter(points_, tracer_, out_.senders, options_.seed, options_.team);
        shooter.add(places, ray_counts(fresh), shot_, stage("gathering"));
        watch_.lap("gathering");
    }

    void repeat() {
        const auto first = static_cast<std::uint32_t>(basis_.size());
        const std::vector<std::uint32_t> repeated = placed_.repeat(receivers_, stage("placement"));
        if (repeated.empty()) return;
        receivers_.resize();
        receivers_.share_rows(first, repeated, stage("placement"));
        watch_.lap("placement");
    }

    void make_test() {
        using Lighting = OperatorOptions::Lighting;
        const auto reflectance = [&] { return out_.senders.means(scene_.surfels.reflectance, out_.areas); };
        std::vector<double> weights;
        for (std::uint32_t j = 0; j < placed_.evenly_placed(); ++j) weights.push_back(stands_for(j));
        if (options_.lighting == Lighting::distant)
            test_ = std::make_unique<VisibilityTest>(points_, tracer_, options_.seed + sky_stream);
        else if (options_.lighting == Lighting::sky)
            test_ = std::make_unique<SkyTest>(points_, tracer_, out_.senders, out_.samples, reflectance(),
                                              options_.seed + sky_stream);
        else
            test_ = std::make_unique<TestLights>(GroupLight(compiled_, out_.senders, out_.samples, points_, out_.areas),
                                                 out_.senders, shot_, reflectance(), test_lamps(), weights,
                                                 options_.seed, stage("test lights"), options_.team);
        test();
        if (options_.lighting != Lighting::local) {
            const bool is_sky = options_.lighting == Lighting::sky;
            test_->normalize_together(received_, weights, is_sky ? 1.0 : little_sky, !is_sky);
        }
        watch_.lap("test lights");
    }
    // What the test tells of rows that are new. Of lamps it takes no rays.
    void test() {
        const bool takes_rays = options_.lighting != OperatorOptions::Lighting::local;
        test_->receive(shot_, received_, takes_rays ? options_.team : Team{});
    }
    double stands_for(std::uint32_t function) const {
        const double r = placed_.first_radius()[basis_.object(function)];
        return r * r;
    }

    std::vector<Vec3> test_lamps() const {
        std::vector<Place> places;
        std::vector<double> air;
        for (std::uint32_t j = 0; j < placed_.evenly_placed(); ++j) {
            places.push_back(place_of(j));
            air.push_back(stands_for(j) * free_path_[receivers_.row(j)]);
        }
        // Nearer than senders are wide no lamp is told from another.
        const double area = std::accumulate(out_.areas.begin(), out_.areas.end(), 0.0);
        const double clearance = std::sqrt(area / static_cast<double>(out_.senders.leaves.size()));
        return places_in_air(points_, tracer_, places, air, options_.region, clearance, options_.test_lights,
                             options_.seed + lamp_stream, stage("lamps"));
    }

    // As RECEIVER-ORACLE of L07 6.3: on the coarsest level around those that differ from others nearby, on finer ones
    // around those whose coefficient is large; of all test lights, in the mean square.
    std::vector<std::uint32_t> to_refine(std::size_t level) {
        const std::uint32_t from = basis_.first(level);
        const std::uint32_t to = level > 0 ? basis_.first(level + 1) : placed_.evenly_placed();
        const std::size_t n = test_->size();
        const double allowed = options_.epsilon * std::exp2(0.5 * static_cast<double>(level));
        std::vector<float> coefs;
        if (level > 0) receivers_.coefficients(received_.values, coefs, n);
        std::vector<char> chosen(to - from, 0);
        parallel_blocks(to - from, 64, [&](std::size_t begin, std::size_t end) {
            std::vector<BasisWeight> near;
            std::vector<float> difference(n);
            for (std::size_t k = begin; k < end; ++k) {
                const auto j = static_cast<std::uint32_t>(from + k);
                if (!receivers_.has(j)) continue;
                const std::uint32_t row = receivers_.row(j);
                const float* values = received_.values.data() + row * n;
                const auto is_off = [&](const float* by) {
                    return test_->is_off(values, by, allowed, received_.variance[row]);
                };
                if (level > 0) {
                    chosen[k] = is_off(coefs.data() + j * n);
                } else {
                    basis_.at_level(0, basis_.position(j), basis_.normal(j), basis_.object(j), near);
                    for (const BasisWeight& w : near) {
                        const std::uint32_t other = receivers_.row(w.function);
                        for (std::size_t c = 0; c < n; ++c) difference[c] = values[c] - received_.values[other * n + c];
                        if ((chosen[k] = is_off(difference.data()))) break;
                    }
                }
            }
        });
        std::vector<std::uint32_t> out;
        for (std::uint32_t k = 0; k < chosen.size(); ++k)
            if (chosen[k]) out.push_back(from + k);
        return out;
    }

    // Functions that are receivers, numbered through, with their rows and parents: level by level, neighbours near each
    // other, so that what is read one after another is.
    void number_functions() {
        number_.assign(basis_.size(), Receivers::none);
        out_.level_begin.assign(1, 0);
        std::vector<std::uint32_t> row_number(shot_.rows.size(), Receivers::none);
        for (std::size_t level = 0; level < basis_.levels(); ++level) {
            std::vector<std::uint32_t> active;
            std::vector<Vec3> positions;
            for (std::uint32_t j = basis_.first(level); j < basis_.first(level + 1); ++j) {
                if (!receivers_.has(j)) continue;
                active.push_back(j);
                positions.push_back(basis_.position(j));
            }
            for (const std::uint32_t k : morton_order(positions)) {
                const std::uint32_t j = active[k], row = receivers_.row(j);
                if (row_number[row] == Receivers::none) {
                    row_number[row] = static_cast<std::uint32_t>(order_.size());
                    order_.push_back(row);
                }
                number_[j] = static_cast<std::uint32_t>(out_.receiver_of.size());
                out_.receiver_of.push_back(row_number[row]);
                receivers_.for_parents(j, [&](std::uint32_t parent, double weight) {
                    if (number_[parent] != Receivers::none)
                        out_.parents.entries.push_back({number_[parent], static_cast<float>(weight)});
                });
                out_.parents.end_row();
            }
            out_.level_begin.push_back(static_cast<std::uint32_t>(out_.receiver_of.size()));
        }
    }

    // Coefficients of what the test tells of the rows, by the numbers that functions have now.
    std::vector<float> test_coefficients() const {
        const std::size_t n = test_->size();
        std::vector<float> values(shot_.rows.size() * n), out;
        for (std::size_t k = 0; k < order_.size(); ++k)
            std::copy_n(received_.values.data() + order_[k] * n, n, values.data() + k * n);
        out_.coefficients(values, n, out);
        return out;
    }

    // Surfels of which the basis knows too little get rows of their own, which are the finest functions there: patches
    // in nooks, and those on which rays contradict the basis, of which those that are alike have one together.
    void give_rows_to_surfels() {
        OwnRowOptions own{options_.epsilon, check_rays, std::min(options_.rays, 2 * least_rays),
                          static_cast<std::size_t>(most_own * static_cast<double>(order_.size()))};
        out_.level_begin.push_back(out_.level_begin.back());
        give_rows_to_nooks(own);
        const RowShooter few(points_, tracer_, out_.senders, options_.seed + check_stream);
        ContradictedSurfels contradicted =
            find_contradicted(places_of(scene_.surfels), out_.areas, few, *test_, out_.at_surfels, test_coefficients(),
                              own, stage("surfels"), options_.team);
        const std::size_t room = memory_with({}).room_for(max_memory_, own.rays);
        const bool is_tight = room < own.most;
        own.most = std::min(own.most, room);
        const std::vector<Cluster> clusters =
            cluster_alike(scene_, out_.areas, contradicted, *test_, own, stage("surfels"));
        if (is_tight && clusters.size() == room) out_.left_out += contradicted.surfels.size() - clusters.size();
        const std::size_t before = shot_.rows.size();
        const std::uint32_t first = add_own_rows(clusters, own.rays);
        std::vector<SparseRows::Entry> functions(scene_.surfels.size(), {Receivers::none, 1.0f});
        for (std::size_t k = 0; k < clusters.size(); ++k)
            for (const std::uint32_t member : clusters[k].members)
                if (const std::uint32_t i = contradicted.surfels[member];
                    is_better(*test_, received_, before + k, contradicted, member, out_.areas[i]))
                    functions[i].column = static_cast<std::uint32_t>(first + k);
        contradicted = {};  // which takes much memory
        give_own_functions(functions, out_.at_surfels);
    }
    void give_rows_to_nooks(const OwnRowOptions& own) {
        std::vector<Cluster> nooks = patch_nooks(placed_.sight(), points_, out_.areas, own.most);
        if (const std::size_t room = memory_with({}).room_for(max_memory_, own.rays); nooks.size() > room) {
            out_.left_out += nooks.size() - room;
            nooks.resize(room);
        }
        const std::uint32_t first = add_own_rows(nooks, own.rays);
        std::vector<SparseRows::Entry> functions(scene_.surfels.size(), {Receivers::none, 1.0f});
        for (std::size_t k = 0; k < nooks.size(); ++k)
            for (const std::uint32_t i : nooks[k].members) {
                const double share = placed_.means().outside(i) / placed_.means().outside(nooks[k].middle);
                functions[i] = {static_cast<std::uint32_t>(first + k), static_cast<float>(share)};
            }
        give_own_functions(functions, out_.at_surfels);
    }
    // From all over the middle surfels, a function for each cluster; returns the first of these.
    std::uint32_t add_own_rows(const std::vector<Cluster>& clusters, int rays) {
        const auto first = static_cast<std::uint32_t>(out_.receiver_of.size());
        std::vector<Place> places;
        for (const Cluster& cluster : clusters) {
            const std::uint32_t i = cluster.middle;
            places.push_back({scene_.surfels.positions[i], scene_.surfels.normals[i], i, i});
            out_.receiver_of.push_back(static_cast<std::uint32_t>(order_.size()));
            order_.push_back(static_cast<std::uint32_t>(shot_.rows.size() + places.size() - 1));
            out_.parents.end_row();
        }
        const RowShooter shooter(points_, tracer_, out_.senders, options_.seed + own_stream, options_.team);
        shooter.add(places, std::vector<int>(places.size(), rays), shot_, stage("surfels"));
        test();
        out_.level_begin.back() = static_cast<std::uint32_t>(out_.receiver_of.size());
        return first;
    }

    const CompiledScene& compiled_;
    const Scene& scene_;
    const OperatorOptions& options_;
    const double max_memory_;
    const StageProgress& progress_;
    Stopwatch watch_;
    const Tracer& tracer_;
    const SurfelPoints points_;
    MultilevelBasis basis_;
    PlacedBasis placed_;
    Receivers receivers_;
    ShotRows shot_;
    std::vector<std::uint32_t> order_;  // of rows, in the operator
    TransportOperator out_;
    std::vector<double> free_path_;  // of each row of the first level
    std::unique_ptr<RowTest> test_;
    RowTest::Received received_;
    std::vector<std::uint32_t> number_;  // of functions of the basis among those of the operator
};

}  // namespace

TransportOperator build_operator(const CompiledScene& compiled, const OperatorOptions& options,
                                 const StageProgress& progress, Figures& timings) {
    require_areas(compiled.scene());
    return OperatorBuilder(compiled, options, progress, timings).run();
}

}  // namespace surflux
