#include "surflux/meshless/meshless_solve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/meshless_exchange.h"
#include "surflux/meshless/oracle.h"
#include "surflux/meshless/placed_basis.h"
#include "surflux/meshless/receiver_system.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/refined_region.h"
#include "surflux/meshless/row_noise.h"
#include "surflux/meshless/surface_light.h"
#include "surflux/meshless/surfel_refinement.h"
#include "surflux/solution/self_check.h"
#include "surflux/solution/stopwatch.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

class MeshlessRadiosity {
public:
    MeshlessRadiosity(const CompiledScene& compiled, const MeshlessOptions& options, const StageProgress& progress,
                      MeshlessSolution& out)
        : scene_(compiled.scene()),
          options_(options),
          tuning_(options.tuning),
          progress_(progress),
          found_(out),
          out_(out.solution),
          watch_(out_.timings),
          field_(std::make_shared<MeshlessField>()),
          tracer_(compiled.tracer(stage("trace"))),
          light_(scene_, tracer_, options.direct, !options.indirect_only, options.rays, tuning_, options.seed,
                 stage("direct"), options.team),
          placed_(scene_, tracer_, light_.points(), field_->basis,
                  {options.radius, options.levels,
                   options.indirect_only ? tuning_.widest_mean : tuning_.widest_direct_mean, options.seed, tuning_},
                  stage("direct")),
          means_(placed_.means()),
          gather_(scene_, tracer_, light_, field_->basis, means_, {options.epsilon_omega, options.seed, tuning_},
                  options.team),
          receivers_(field_->basis, placed_.sight()),
          system_(receivers_, gather_, options.bounces),
          noise_(gather_) {
        field_->largest_deviation = tuning_.largest_deviation;
        field_->largest_part = tuning_.largest_part;
        beside_ = beside_basis();
        watch_.lap("direct");
        out.field = field_;
    }

    void run() {
        placed_.add_first(stage("placement"));
        placed();
        gather(all_functions());
        solve(tuning_.rough_tolerance, 0);
        reduce_noise();
        for (int level = 1; level < options_.levels; ++level) {
            const std::vector<std::uint32_t> refined =
                oracle().refined(static_cast<std::size_t>(level - 1), options_.epsilon_e);
            if (refined.empty()) break;
            placed_.add_around(refined, stage("placement"));
            placed();
            const std::vector<std::uint32_t> children = children_of(field_->basis, refined);
            if (children.empty()) break;
            gather(children);
            solve(tuning_.rough_tolerance, refined.size());
            reduce_noise();
        }
        for (int k = 0; k < tuning_.repeats; ++k) repeat();
        finish();
    }

private:
    Progress stage(const char* name) const { return progress_ ? progress_(name) : Progress{}; }

    Oracle oracle() const {
        return {field_->basis,
                receivers_,
                noise_.standard_error(),
                placed_.first_radius(),
                placed_.evenly_placed(),
                system_.rows(),
                *field_,
                tuning_,
                beside_};
    }

    // RMS over the surface.
    double beside_basis() const {
        const Surfels& s = scene_.surfels;
        double sum = 0.0, area = 0.0;
        for (std::size_t i = 0; i < s.size(); ++i) {
            const double light = color_norm(light_.beside_basis(i));
            sum += s.areas[i] * light * light;
            area += s.areas[i];
        }
        return area > 0.0 ? std::sqrt(sum / area) : 0.0;
    }

    // Where rows have more noise than light may be off by, as in a room that is lit through a gap, they are shot anew.
    void reduce_noise() {
        std::vector<double> allowed = find_noise();
        const std::vector<HemisphereGather::Shot> rows =
            noise_.wanted(allowed, static_cast<int>(tuning_.most_aimed * options_.rays));
        if (rows.empty()) return;
        const Progress progress = stage("gathering");
        system_.aim(rows, noise_.aims(rows, system_.sent(), progress), progress);
        watch_.lap("gathering");
        solve(tuning_.rough_tolerance, 0);
        find_noise();
    }

    // Returns what each row may be off by for want of rays.
    std::vector<double> find_noise() {
        const Oracle::Wanted wanted = oracle().wanted(options_.epsilon_e);
        std::vector<double> allowed;
        for (const Rgb& value : system_.rows().values)
            allowed.push_back(std::max(1e-300, tuning_.allowed_noise * wanted.where_dim(color_norm(value))));
        noise_.find(system_.sent(), allowed);
        return allowed;
    }

    // The basis has got a level.
    void placed() {
        receivers_.resize();
        watch_.lap("placement");
        if (field_->basis.levels() > 1) gather_.extend(stage("gathering"));
        watch_.lap("gathering");
    }

    void repeat() {
        const auto first = static_cast<std::uint32_t>(field_->basis.size());
        const std::vector<std::uint32_t> repeated = placed_.repeat(receivers_, stage("placement"));
        if (repeated.empty()) return;
        placed();
        receivers_.share_rows(first, repeated, stage("placement"));
    }

    // Makes functions receivers, and those that theirs are the differences from.
    void gather(const std::vector<std::uint32_t>& functions) {
        const MultilevelBasis& basis = field_->basis;
        const std::vector<std::uint32_t> fresh = receivers_.add(functions, stage("gathering"));
        std::vector<Place> places;
        std::vector<std::uint32_t> objects;
        std::vector<int> counts;
        for (const std::uint32_t j : fresh) {
            places.push_back({basis.position(j), basis.normal(j), placed_.sight().surfel(j), Place::point});
            objects.push_back(basis.object(j));
            const int least = std::min(options_.rays, static_cast<int>(tuning_.least_rays));
            counts.push_back(placed_.is_in_nook(j) ? least : std::max(least, options_.rays >> (basis.level_of(j) / 2)));
        }
        gather_.add(places, counts, stage("gathering"));
        noise_.add(places, objects, counts, stage("gathering"));
        watch_.lap("gathering");
        std::vector<Rgb> lit;
        if (!options_.indirect_only) lit = light_.direct_at(places, stage("direct"));
        system_.add(places.size(), lit);
        watch_.lap("direct");
    }

    void solve(double tolerance, std::size_t refined) {
        const LinearReport linear = system_.solve(tolerance, *field_, stage("solve"));
        watch_.lap("solve");
        report(linear, refined);
    }

    void report(const LinearReport& linear, std::size_t refined) {
        out_.history.push_back({{"level", static_cast<double>(field_->basis.levels() - 1)},
                                {"points", static_cast<double>(field_->basis.size())},
                                {"cut", static_cast<double>(system_.rows().values.size())},
                                {"refined", static_cast<double>(refined)},
                                {"links", static_cast<double>(gather_.links())},
                                {"rays", static_cast<double>(gather_.rays())},
                                {"applications", static_cast<double>(linear.applications)},
                                {"residual", linear.residual},
                                {"imbalance", imbalance_},
                                {"imbalance_left", imbalance_left_},
                                {"seconds", total_seconds(out_.timings)}});
    }

    std::vector<std::uint32_t> all_functions() const {
        std::vector<std::uint32_t> out(field_->basis.size());
        std::iota(out.begin(), out.end(), 0u);
        return out;
    }

    // What rays' variance and the weights would lose or make of the light is mended where it is: first of any light, as
    // well as factors of senders can, then of the light that there is.
    void keep_energy() {
        const double tolerance = std::max(options_.tolerance, tuning_.balanced_tolerance);
        solve(tolerance, 0);
        const MeshlessExchange exchange(scene_, field_->basis, means_, receivers_, gather_, stage("solve"));
        const ReciprocalScaling scaling =
            system_.scale_by_reciprocity(exchange, *field_, tuning_.reciprocity, stage("solve"));
        imbalance_ = scaling.before;
        imbalance_left_ = scaling.after;
        solve(tolerance, 0);
        system_.keep_power(exchange, scaling, *field_);
    }

    void finish() {
        if (options_.bounces < 0) {
            keep_energy();
            watch_.lap("solve");
        }
        solve(options_.tolerance, 0);
        field_->gathered.resize(field_->basis.size());
        field_->values.resize(field_->basis.size());
        for (std::uint32_t j = 0; j < field_->basis.size(); ++j) {
            if (!receivers_.has(j)) continue;
            field_->gathered[j] = true;
            field_->values[j] = {system_.rows().values[receivers_.row(j)], system_.rows().direct[receivers_.row(j)]};
        }
        write();
        watch_.lap("evaluation");
        check_solution(scene_, tracer_, options_.seed, stage("self-check"), out_, options_.team, tuning_.self_check);
        for (const auto& figure : power_) out_.history.back().push_back(figure);
    }

    void write();

    const Scene& scene_;
    const MeshlessOptions& options_;
    const MeshlessTuning& tuning_;
    const StageProgress& progress_;
    MeshlessSolution& found_;
    Solution& out_;
    Stopwatch watch_;
    std::shared_ptr<MeshlessField> field_;
    const Tracer& tracer_;
    const SurfaceLight light_;
    PlacedBasis placed_;
    const SurfelMeans& means_;
    HemisphereGather gather_;
    Receivers receivers_;
    ReceiverSystem system_;
    RowNoise noise_;
    double beside_ = 0.0;     // as the oracle has it
    double imbalance_ = 0.0;  // of what surfels send and what is received of it, before it was scaled
    double imbalance_left_ = 0.0;
    Figures power_;
};

// At the surfels of the scene: at the centre of disks, the mean over patches; where the basis is still off, by rays
// from all over each.
void MeshlessRadiosity::write() {
    const Surfels& s = scene_.surfels;
    const std::size_t n = s.size();
    // With a number of bounces, senders have one less.
    std::vector<Rgb> sending;
    receivers_.coefficients(system_.before(), sending);
    const Oracle of_points = oracle();
    const SurfelRefinement::Options options{options_.epsilon_e, options_.rays, options_.bounces != 0};
    SurfelRefinement refinement(scene_, light_, means_, of_points, sending, options, gather_);
    const std::size_t rays = gather_.rays();
    refinement.run(stage("gathering"));
    const std::vector<std::uint32_t>& refined = refinement.surfels();
    figure(out_.history.back(), "rays") += static_cast<double>(gather_.rays() - rays);
    out_.history.back().push_back({"surfels_gathered", static_cast<double>(refined.size())});
    const MeshlessExchange exchange(scene_, field_->basis, means_, receivers_, gather_, stage("gathering"));
    gather_.clear();
    watch_.lap("gathering");
    out_.surfels = s;
    for (std::size_t i = 0; i < n; ++i) {
        found_.lit.push_back(light_.direct_beside_basis(i));
        if (!light_.emitters().empty()) out_.emitted.push_back(light_.emitted_at_surfel(i));
    }
    std::vector<std::uint32_t> own(n, Receivers::none);
    for (std::size_t k = 0; k < refined.size(); ++k) own[refined[k]] = static_cast<std::uint32_t>(k);
    out_.parents.resize(n);
    out_.levels.resize(n);
    out_.direct.resize(n);
    out_.irradiance.resize(n);
    out_.radiosity.resize(n);
    const auto write_one = [&](std::size_t i) {
        MeshlessField::At light;
        std::size_t level = field_->basis.levels();  // surfels by themselves are as a level of their own
        if (own[i] != Receivers::none) {
            light = refinement.found()[own[i]].light;
        } else {
            std::uint32_t finest = 0;
            means_.for_functions(i, [&](std::uint32_t j, double weight) {
                light.all += weight * field_->coefficients[j];
                light.direct += weight * field_->direct[j];
                if (field_->gathered[j]) finest = j;
            });
            light.clamp();
            level = field_->basis.level_of(finest);
        }
        light.all += light_.beside_basis(i);
        light.direct += light_.direct_beside_basis(i);
        out_.parents[i] = static_cast<std::uint32_t>(i);
        out_.levels[i] = static_cast<std::int32_t>(level);
        out_.direct[i] = light.direct;
        out_.irradiance[i] = light.all;
        out_.radiosity[i] = s.emission[i] + s.reflectance[i] * light.all;
    };
    parallel_for(n, 256, write_one, stage("evaluation"));
    power_ = exchange.power(out_, refinement);
}

}  // namespace

MeshlessSolution solve_meshless(const CompiledScene& compiled, const MeshlessOptions& options,
                                const StageProgress& progress) {
    require(compiled.scene().surfels.size() > 0, "scene: it has no surfels");
    require_areas(compiled.scene());
    require(options.levels >= 1 && options.levels <= 10, "levels: wanted 1 to 10, got ", options.levels);
    require(options.epsilon_e > 0.0, "epsilon_e: wanted more than 0, got ", options.epsilon_e);
    require(options.epsilon_omega > 0.0, "epsilon_omega: wanted more than 0, got ", options.epsilon_omega);
    require(options.rays >= 16 && options.rays <= 65535, "rays: wanted 16 to 65535, got ", options.rays);
    require(options.tolerance > 0.0 && options.tolerance < 1.0, "tolerance: wanted in (0, 1), got ", options.tolerance);
    MeshlessSolution out;
    MeshlessRadiosity(compiled, options, progress, out).run();
    return out;
}

}  // namespace surflux
