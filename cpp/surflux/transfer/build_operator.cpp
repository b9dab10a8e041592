#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "surflux/core/available_memory.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/lights/hemisphere_row.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/placed_basis.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/refined_region.h"
#include "surflux/scene/extent.h"
#include "surflux/solution/stopwatch.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/function_means.h"
#include "surflux/transfer/operator_memory.h"
#include "surflux/transfer/places_in_air.h"
#include "surflux/transfer/row_shooter.h"
#include "surflux/transfer/sky_irradiance.h"
#include "surflux/transfer/sky_visibility.h"
#include "surflux/transfer/test_lights.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

namespace {

// A finer level's receiver speaks for less of the surface: from every other level on it has half the rays.
constexpr int least_rays = 128;
constexpr int few_rays = 32;          // that tell how far it is to what a place sees
constexpr int check_rays = 128;       // that tell whether the basis is off at a surfel
constexpr double most_own = 0.25;     // rows of such surfels, of as many as receivers have
constexpr int most_repeats = 2;       // of receivers of clouds (PlacedBasis)
constexpr double widest_mean = 1.0;   // as SurfelMeans has it
constexpr double significance = 2.0;  // standard errors that a difference must be beyond
constexpr std::uint64_t sample_stream = 0x5e17, lamp_stream = 0x1a3b, check_stream = 0x2c4d, own_stream = 0x3d5e,
                        sky_stream = 0x4e6f;

class OperatorBuilder {
public:
    OperatorBuilder(const CompiledScene& compiled, const OperatorOptions& options, const StageProgress& progress,
                    Figures& timings)
        : compiled_(compiled),
          scene_(compiled.scene()),
          options_(options),
          max_memory_(options.max_memory > 0.0 ? options.max_memory : 0.75 * available_memory()),
          progress_(progress),
          watch_(timings),
          tracer_(compiled.tracer(stage("trace"))),
          points_(scene_.surfels),
          placed_(scene_, tracer_, points_, basis_, {options.radius, options.levels, widest_mean, options.seed},
                  stage("placement")),
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
            test_->receive(out_, received_);
        }
        for (int k = 0; k < most_repeats; ++k) repeat();
        number_functions();
        out_.at_surfels =
            means_at_surfels(placed_.means(), basis_, number_, scene_.surfels.size(), stage("projection"));
        watch_.lap("projection");
        give_rows_to_surfels();
        watch_.lap("surfels");
        out_.at_groups = means_at_groups(out_.at_surfels, out_.senders, scene_.surfels.areas, out_.areas);
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

    // The mean length of rays from receivers, and from surfels: pi times it, over the volume of the air, is the mean
    // irradiance from a lamp that may be anywhere in it. Of distant light it is the share of rays that escape.
    void find_free_paths(const std::vector<std::uint32_t>& receivers) {
        free_path_.resize(receivers.size());
        parallel_blocks(
            receivers.size(), 64,
            [&](std::size_t begin, std::size_t end) {
                HemisphereRow row;
                for (std::size_t k = begin; k < end; ++k) {
                    gather_row(points_, tracer_, place_of(receivers[k]), few_rays, options_.seed + lamp_stream, row);
                    double sum = 0.0;
                    for (const Hit& hit : row.hits) sum += length_of(hit);
                    free_path_[receivers_.row(receivers[k])] = sum / few_rays;
                }
            },
            stage("grouping"));
    }
    double length_of(const Hit& hit) const {
        if (options_.lighting != OperatorOptions::Lighting::local) return hit ? 0.0 : 1.0;
        return hit ? hit.distance : 0.0;
    }

    void group_senders() {
        std::vector<double> of_function, of_surfel;
        receivers_.coefficients(free_path_, of_function);
        for (std::size_t i = 0; i < scene_.surfels.size(); ++i) {
            double path = 0.0;
            placed_.means().for_functions(i, [&](std::uint32_t j, double weight) { path += weight * of_function[j]; });
            of_surfel.push_back(std::max(0.0, path));
        }
        out_.senders = SenderGroups(scene_, out_.areas, of_surfel, options_.senders, stage("grouping"));
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
        return {scene_.surfels.size(), placed_.means().weights(), test_size(), out_, rays};
    }

    // Rows of receivers that have none, in the order in which these are numbered.
    void shoot(const std::vector<std::uint32_t>& fresh) {
        std::vector<Place> places;
        for (const std::uint32_t j : fresh) places.push_back(place_of(j));
        const RowShooter shooter(points_, tracer_, out_.senders, options_.seed);
        shooter.add(places, ray_counts(fresh), out_, stage("gathering"));
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
            test_ = std::make_unique<VisibilityTest>(tracer_, options_.seed + sky_stream);
        else if (options_.lighting == Lighting::sky)
            test_ = std::make_unique<SkyTest>(tracer_, out_, scene_.surfels.normals, reflectance(),
                                              options_.seed + sky_stream);
        else
            test_ = std::make_unique<TestLights>(compiled_, out_, reflectance(), test_lamps(), weights, options_.seed,
                                                 stage("test lights"));
        test_->receive(out_, received_);
        if (options_.lighting == Lighting::sky) {
            test_->normalize(received_, weights);
            received_ = {};
            test_->receive(out_, received_);
        }
        watch_.lap("test lights");
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
        return places_in_air(points_, tracer_, places, air, options_.region, options_.test_lights,
                             options_.seed + lamp_stream);
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
                double off = 0.0;
                if (level > 0) {
                    off = test_->mean_square(coefs.data() + j * n);
                } else {
                    basis_.at_level(0, basis_.position(j), basis_.normal(j), basis_.object(j), near);
                    for (const BasisWeight& w : near) {
                        const std::uint32_t other = receivers_.row(w.function);
                        for (std::size_t c = 0; c < n; ++c)
                            difference[c] = received_.values[row * n + c] - received_.values[other * n + c];
                        off = std::max(off, test_->mean_square(difference.data()));
                    }
                }
                chosen[k] = is_off(off, allowed, received_.variance[row]);
            }
        });
        std::vector<std::uint32_t> out;
        for (std::uint32_t k = 0; k < chosen.size(); ++k)
            if (chosen[k]) out.push_back(from + k);
        return out;
    }
    static bool is_off(double mean_square, double allowed, float variance) {
        return mean_square > allowed * allowed + significance * significance * static_cast<double>(variance);
    }

    // Functions that are receivers, numbered through, and their parents.
    void number_functions() {
        number_.assign(basis_.size(), Receivers::none);
        out_.level_begin.assign(1, 0);
        for (std::size_t level = 0; level < basis_.levels(); ++level) {
            for (std::uint32_t j = basis_.first(level); j < basis_.first(level + 1); ++j) {
                if (!receivers_.has(j)) continue;
                number_[j] = static_cast<std::uint32_t>(out_.receiver_of.size());
                out_.receiver_of.push_back(receivers_.row(j));
                receivers_.for_parents(j, [&](std::uint32_t parent, double weight) {
                    if (number_[parent] != Receivers::none)
                        out_.parents.entries.push_back({number_[parent], static_cast<float>(weight)});
                });
                out_.parents.end_row();
            }
            out_.level_begin.push_back(static_cast<std::uint32_t>(out_.receiver_of.size()));
        }
    }

    // Surfels on which rays contradict the basis, those first that make most of its error. Each gets a row of its own.
    void give_rows_to_surfels() {
        struct Off {
            std::uint32_t surfel;
            double error;
        };
        const std::size_t n = scene_.surfels.size(), channels = test_->size();
        std::vector<float> coefs;
        out_.coefficients(received_.values, channels, coefs);
        std::vector<Off> off;
        const std::vector<Place> places = places_of(scene_.surfels);
        const RowShooter few(points_, tracer_, out_.senders, options_.seed + check_stream);
        const Progress progress = stage("surfels");
        constexpr std::size_t batch = 8192;
        for (std::size_t first = 0; first < n; first += batch) {
            report(progress, first, n);
            std::vector<Place> asked;
            for (std::size_t i = first; i < std::min(n, first + batch); ++i)
                if (out_.areas[i] > 0.0) asked.push_back(places[i]);
            TransportOperator own;
            few.add(asked, std::vector<int>(asked.size(), check_rays), own, {});
            RowTest::Received received;
            test_->receive(own, received);
            parallel_for(asked.size(), 64, [&](std::size_t k) {
                const std::uint32_t i = asked[k].surfel;
                float* difference = received.values.data() + k * channels;
                out_.at_surfels.for_row(i, [&](std::uint32_t function, float weight) {
                    const float* by_basis = coefs.data() + function * channels;
                    for (std::size_t c = 0; c < channels; ++c) difference[c] -= weight * by_basis[c];
                });
            });
            for (std::size_t k = 0; k < asked.size(); ++k) {
                const double square = test_->mean_square(received.values.data() + k * channels);
                const auto variance = static_cast<double>(received.variance[k]);
                if (is_off(square, options_.epsilon, received.variance[k]))
                    off.push_back({asked[k].surfel, out_.areas[asked[k].surfel] * (square - variance)});
            }
        }
        std::sort(off.begin(), off.end(), [](const Off& a, const Off& b) {
            return a.error > b.error || (a.error == b.error && a.surfel < b.surfel);
        });
        off.resize(std::min(off.size(), static_cast<std::size_t>(most_own * static_cast<double>(out_.rows.size()))));
        const int own_rays = std::min(options_.rays, 2 * least_rays);
        const std::size_t fitting = std::min(off.size(), memory_with({}).room_for(max_memory_, own_rays));
        out_.left_out += off.size() - fitting;
        off.resize(fitting);
        std::vector<Place> own;
        for (const Off& one : off) own.push_back(places[one.surfel]);
        const std::size_t before = out_.rows.size();
        const RowShooter shooter(points_, tracer_, out_.senders, options_.seed + own_stream);
        shooter.add(own, std::vector<int>(own.size(), own_rays), out_, progress);
        SparseRows all;
        std::vector<std::uint32_t> function(n, Receivers::none);
        for (std::size_t k = 0; k < own.size(); ++k) {
            function[own[k].surfel] = static_cast<std::uint32_t>(out_.receiver_of.size());
            out_.receiver_of.push_back(static_cast<std::uint32_t>(before + k));
            out_.parents.end_row();
        }
        out_.level_begin.push_back(static_cast<std::uint32_t>(out_.receiver_of.size()));
        for (std::size_t i = 0; i < n; ++i) {
            if (function[i] != Receivers::none)
                all.entries.push_back({function[i], 1.0f});
            else
                for (std::uint32_t k = out_.at_surfels.begin[i]; k < out_.at_surfels.begin[i + 1]; ++k)
                    all.entries.push_back(out_.at_surfels.entries[k]);
            all.end_row();
        }
        out_.at_surfels = std::move(all);
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
    TransportOperator out_;
    std::vector<double> free_path_;  // of each row of the first level
    std::unique_ptr<RowTest> test_;
    RowTest::Received received_;
    std::vector<std::uint32_t> number_;  // of functions of the basis among those of the operator
};

}  // namespace

TransportOperator build_operator(const CompiledScene& compiled, const OperatorOptions& options,
                                 const StageProgress& progress, Figures& timings) {
    return OperatorBuilder(compiled, options, progress, timings).run();
}

}  // namespace surflux
