#include "surflux/radiosity/global_refinement.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/available_memory.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/cut_test.h"
#include "surflux/radiosity/gathered_system.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/radiosity/local_light.h"
#include "surflux/radiosity/node_rays.h"
#include "surflux/radiosity/write_leaves.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/nodal_regression.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr int most_applications = 100;
constexpr std::uint64_t probe_stream = 0x9706e, particle_stream = 0xa817f;

class GlobalRefinement {
public:
    GlobalRefinement(const Scene& scene, const Tracer& tracer, const Sight& sight, SurfelTree& tree,
                     const RefinementOptions& options, const StageProgress& progress, Stopwatch& watch, Solution& out)
        : scene_(scene),
          tracer_(tracer),
          options_(options),
          tuning_(options.tuning),
          progress_(progress),
          out_(out),
          watch_(watch),
          emitters_(LightSampler::of_surfels(scene)),
          skies_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::constant_sky),
          sky_cells_(scene.lights),
          sight_(sight),
          tree_(tree),
          points_(scene.surfels),
          gathering_(points_, tracer, tree_, skies_, options.seed, options.tuning, options.team),
          probes_(points_, tracer, tree_, skies_, options.seed + probe_stream, options.tuning, options.team),
          test_(std::make_unique<CutTest>(tree_, gathering_, probes_, options.seed + probe_stream, options.tuning)),
          sources_(scene, points_, tracer, tree_, &emitters_, &sky_cells_, options.direct, options.rays, options.seed,
                   options.team) {
        double squared = 0.0, total = 0.0;
        for (double area : scene.surfels.areas) squared += area * area, total += area;
        usual_area_ = options.tuning.usual_share * squared / total;
        rays_ = std::make_unique<NodeRays>(tree_, gathering_, options.rays, usual_area_, options.tuning);
        sources_.update(stage("direct"));
        watch_.lap("direct");
        const bool grey = is_grey(scene.surfels.reflectance) && is_grey(scene.surfels.emission) && sources_.is_grey() &&
                          is_grey({skies_.constant_sky()});
        system_ = std::make_unique<GatheredSystem>(tree_, gathering_, sources_, emitters_, grey ? 1 : 3, options.team);
    }

    void run() {
        const auto first_nodes =
            static_cast<std::size_t>(static_cast<double>(scene_.surfels.size()) / tuning_.surfels_per_first_node);
        const auto [from, to] = tree_.level_of_at_least(std::max(whole_number(tuning_.least_first_nodes), first_nodes));
        for (std::uint32_t node = from; node < to; ++node) cut_.nodes.push_back(node);
        cut_.find_places(tree_, stage("gathering"));
        solve_on_nodes(0);
        for (std::size_t iteration = 0; iteration < whole_number(tuning_.most_iterations); ++iteration) {
            find_allowed();
            const CutTest::Result found = (*test_)(cut_, *system_, values_, *sent_, allowed_, arrived(), reference_,
                                                   usual_area_, most_rays(), stage("gathering"));
            error_ = found.error;
            out_.history.back().emplace_back("error", error_);
            if (iteration == 0 && options_.insert) insert_for_sources();
            double area = 0.0, total = 0.0;
            for (std::size_t k = 0; k < cut_.nodes.size(); ++k) {
                const double of_node = tree_.area(cut_.nodes[k]);
                area += found.refine[k] || found.rays[k] > 0 ? of_node : 0.0;
                total += of_node;
            }
            if (!(area > 0.0)) break;
            cut_.want(found.rays);
            const std::size_t refined = replace(found.refine);
            watch_.lap("refinement");
            solve_on_nodes(refined);
            if (area < tuning_.little * total) break;
        }
        balance();
        sharpen();
        if (options_.insert) {
            solve_smoothly(Insertion(tree_, insertion_options()).asked());
            if (insert_for_indirect()) {
                balance();
                sharpen();
            }
        }
        solve_smoothly({});
        write_light();
    }

private:
    static constexpr std::uint32_t none = SurfelTree::none;

    Progress stage(const char* name) const { return progress_ ? progress_(name) : Progress{}; }
    InsertionOptions insertion_options() const {
        return {smallest_radius(scene_.surfels, tuning_.smallest_share), tuning_};
    }
    int most_rays() const { return static_cast<int>(std::min(65535.0, tuning_.most_more_rays * options_.rays)); }

    void shoot() {
        rays_->shoot(cut_, sent_, system_->channels(), particles_, stage("gathering"));
        watch_.lap("gathering");
    }

    // More rays for nodes whose own are too few, once the cut is as it will be.
    void sharpen() {
        for (std::size_t round = 0; round < whole_number(tuning_.most_sharpenings) && rays_->any_aimed(); ++round) {
            solve_on_nodes(0);
            find_allowed();
            if (!cut_.want(
                    test_->rays_wanted(cut_, *system_, *sent_, allowed_, usual_area_, most_rays(), stage("gathering"))
                        .rays))
                return;
        }
    }

    void solve_on_nodes(std::size_t refined) {
        shoot();
        system_->take_by_nodes(cut_);
        report(solve(std::max(tuning_.rough_tolerance, options_.tolerance)), refined);
    }

    // In units of the light that there was before.
    LinearReport solve(double tolerance) {
        std::vector<double> unit;
        const double least = tuning_.dimmest * reference_;
        if (least > 0.0)
            for (std::size_t k = 0; k < cut_.rows.size(); ++k)
                unit.push_back(std::max(least, luminance(system_->value(values_, k) + system_->found(k))));
        return system_->solve(tolerance, most_applications, values_, unit, stage("solve"));
    }

    // The error that each node may have.
    void find_allowed() {
        const Progress starting = standing_at(0, cut_.rows.size(), stage("refinement"));
        const double least = tuning_.dimmest * reference_;
        allowed_.error.assign(cut_.rows.size(), options_.zeta * reference_);
        allowed_.noise = allowed_.error;
        if (!(least > 0.0)) return;
        const std::vector<double> light = local_light(tree_, gathering_, cut_, *system_, values_, least, starting);
        for (std::size_t k = 0; k < light.size(); ++k) {
            allowed_.noise[k] = options_.zeta * tuning_.local_weight * light[k];
            allowed_.error[k] = std::min(options_.zeta * reference_, allowed_.noise[k]);
        }
    }

    // What this iteration came to.
    void report(const LinearReport& linear, std::size_t refined) {
        const Progress at_end = standing_at(1, 1, stage("solve"));
        sent_ = &system_->sent(values_, at_end);
        const GatheredSystem::Account all = system_->account(values_, at_end);
        reference_ = std::sqrt(all.squared / all.area);
        out_.history.push_back({{"surfels", static_cast<double>(tree_.leaves())},
                                {"cut", static_cast<double>(cut_.nodes.size())},
                                {"refined", static_cast<double>(refined)},
                                {"inserted", static_cast<double>(tree_.points() - scene_.surfels.size())},
                                {"left_out", static_cast<double>(left_out_)},
                                {"links", static_cast<double>(gathering_.links())},
                                {"rays", static_cast<double>(gathering_.rays() + probes_.rays())},
                                {"channels", static_cast<double>(system_->channels())},
                                {"applications", static_cast<double>(linear.applications)},
                                {"residual", linear.residual},
                                {"imbalance", imbalance_},
                                {"imbalance_left", imbalance_left_}});
        const Figures balance = all.power.figures();
        out_.history.back().insert(out_.history.back().end(), balance.begin(), balance.end());
        watch_.lap("solve");
        out_.history.back().emplace_back("seconds", total_seconds(out_.timings));
    }

    // What particles bring to nodes, where some are dim.
    std::vector<double> arrived() {
        if (particles_.empty()) {
            double dim = 0.0, all = 0.0;
            for (std::size_t k = 0; k < cut_.nodes.size(); ++k) {
                const double area = tree_.area(cut_.nodes[k]);
                const double light = luminance(system_->value(values_, k) + system_->found(k) +
                                               sources_[tree_.representative(cut_.nodes[k])]);
                if (light < tuning_.dim * reference_) dim += area;
                all += area;
            }
            if (!(dim > tuning_.little * all)) return {};
            particles_.shoot(tree_, tracer_, *sent_, system_->channels(), options_.seed + particle_stream,
                             stage("gathering"));
        }
        return particles_.irradiance(tree_, cut_);
    }

    // By the node above a point, or above the surfel that it was just inserted below.
    double allowed(std::uint32_t p) const {
        const std::uint32_t k = cut_.place_of[p < cut_.place_of.size() ? p : tree_.surfel(p)];
        return k == none ? options_.zeta * reference_ : allowed_.error[k];
    }

    // Borders of shadows, from what needs no solving.
    void insert_for_sources() {
        const auto source = [&](std::uint32_t p) { return luminance(sources_[p]); };
        const auto wanted = [&](std::uint32_t p) {
            return allowed(p) + tuning_.significance * sources_.standard_error(p);
        };
        Insertion insertion(tree_, insertion_options(), options_.team);
        insertion.refine_all(source, wanted, [&] { sources_.update(stage("insertion")); }, stage("insertion"));
        left_out_ = insertion.left_out();
        cut_.find_places(tree_, stage("insertion"));
        watch_.lap("insertion");
    }

    // Where the whole field is not what the leaves around say.
    bool insert_for_indirect() {
        find_allowed();
        const auto first = static_cast<std::uint32_t>(tree_.points());
        const auto all = [&](std::uint32_t p) { return luminance(system_->irradiance(p, values_)); };
        const auto wanted = [&](std::uint32_t p) {
            return allowed(p) +
                   tuning_.significance *
                       std::hypot(sources_.standard_error(p),
                                  CutTest::standard_error(gathering_, cut_.rows[cut_.place_of[p]], *system_, *sent_));
        };
        Insertion insertion(tree_, insertion_options(), options_.team);
        const bool any_inserted = insertion.refine(all, wanted, stage("insertion"));
        left_out_ = insertion.left_out();
        if (!any_inserted) return false;
        sources_.update(stage("insertion"));
        cut_.find_places(tree_, stage("insertion"));
        for (bool any = true; any;) {
            std::vector<char> opened(cut_.nodes.size(), 0);
            for (std::uint32_t point = first; point < tree_.points(); ++point) {
                const std::uint32_t k = cut_.place_of[point];
                if (k != none && !tree_.is_leaf(cut_.nodes[k])) opened[k] = 1;
            }
            any = replace(opened) > 0;
        }
        watch_.lap("insertion");
        return true;
    }

    std::size_t replace(const std::vector<char>& chosen) {
        return cut_.replace(tree_, chosen, values_, system_->channels(), stage("refinement"));
    }

    void balance() {
        while (replace(cut_.unbalanced(tree_, tuning_, stage("refinement"))) > 0) {
        }
        watch_.lap("refinement");
    }

    // By interpolation: where it is asked for, for a first look, or everywhere.
    void solve_smoothly(const std::vector<char>& asked) {
        shoot();
        if (asked.empty()) {  // the last time: what only earlier stages need goes
            tree_.end_of_rays();
            sources_.drop_errors();
            test_.reset();
            rays_->end();
            give_back_memory();
        }
        // What is buried, as the floor below a plinth is, stays apart: it is no neighbour of what is lit beside it.
        NodePlaces nodes(tree_, cut_);
        for (std::size_t k = 0; k < cut_.rows.size(); ++k)
            nodes.objects[k] = 2 * nodes.objects[k] + (gathering_.row(cut_.rows[k]).is_buried() ? 1 : 0);
        const Progress starting = standing_at(0, tree_.points(), stage("interpolation"));
        std::vector<std::uint32_t> objects(tree_.points());
        const auto find_object = [&](std::size_t k) {
            const auto p = static_cast<std::uint32_t>(k);
            objects[p] = 2 * tree_.object(p);
            if (cut_.place_of[p] != none && sources_[p] == Rgb{} &&
                gathering_.row(cut_.rows[cut_.place_of[p]]).is_buried())
                ++objects[p];
        };
        parallel_for(tree_.points(), 4096, find_object, starting);
        field_ = std::make_unique<NodalField>(std::move(nodes.positions), std::move(nodes.normals),
                                              std::move(nodes.objects), starting, tuning_.nodal);
        system_->interpolate(cut_, *field_, objects, values_, sight_, asked, stage("interpolation"));
        std::vector<std::uint32_t>().swap(objects);
        watch_.lap("interpolation");
        LinearReport linear = solve(asked.empty() ? tuning_.balanced_tolerance : tuning_.rough_tolerance);
        if (asked.empty()) {
            // Energy that variance of rays and bias of interpolation would lose or make is kept where it is.
            const ReciprocalScaling scaling =
                system_->scale_by_reciprocity(values_, tuning_.reciprocity, stage("solve"));
            imbalance_ = scaling.before;
            imbalance_left_ = scaling.after;
            const LinearReport last = solve(options_.tolerance);
            linear = {linear.applications + last.applications, last.residual};
        }
        report(linear, 0);
        out_.history.back().emplace_back("error", error_);  // or less
    }

    void write_light();

    const Scene& scene_;
    const Tracer& tracer_;
    const RefinementOptions& options_;
    const RefinementTuning& tuning_;
    const StageProgress& progress_;
    Solution& out_;
    Stopwatch& watch_;
    const LightSampler emitters_, skies_;
    const SkyCells sky_cells_;
    const Sight& sight_;
    SurfelTree& tree_;
    const SurfelPoints points_;
    Gathering gathering_, probes_;
    std::unique_ptr<CutTest> test_;
    LitPoints sources_;
    std::unique_ptr<GatheredSystem> system_;
    Cut cut_;
    std::unique_ptr<NodeRays> rays_;
    LightParticles particles_{tuning_};
    std::vector<double> values_;
    const std::vector<double>* sent_ = nullptr;
    CutTest::Allowed allowed_;
    std::size_t left_out_ = 0;  // of what was to be inserted, for want of room
    double reference_ = 0.0;    // RMS of H
    double imbalance_ = 0.0;    // of what senders send and what is received of it, before it was scaled
    double imbalance_left_ = 0.0;
    double error_ = 0.0;       // estimated
    double usual_area_ = 0.0;  // of a node that gets all rays
    std::unique_ptr<NodalField> field_;
};

// Irradiance of the leaves, and the cut that it comes from.
void GlobalRefinement::write_light() {
    const std::vector<std::uint32_t> leaves = tree_.all_leaves();
    const auto leaf_at = [&](std::size_t k) {
        const std::uint32_t p = leaves[k];
        return NodalField::Place{tree_.position(p), tree_.normal(p), tree_.area(p), system_->weights(p)};
    };
    const auto at_leaves = [&](std::vector<TiltedRgb> values) {
        const Progress progress = stage("interpolation");
        return field_->at_conservatively(field_->fit(std::move(values), &sight_, progress), leaves.size(), leaf_at,
                                         progress);
    };
    std::vector<TiltedRgb> at_nodes(cut_.rows.size());
    // Factors of senders keep energy and say nothing of where light comes from: the same from everywhere has no tilt.
    const Progress starting = standing_at(0, leaves.size(), stage("interpolation"));
    const std::vector<double>& radiosity = system_->radiosity(values_, starting);
    std::vector<Rgb> light(at_nodes.size());
    std::vector<double> errors(at_nodes.size());
    const auto gather_one = [&](std::size_t k) {
        at_nodes[k] = gathering_.gather_tilted(cut_.rows[k], radiosity, system_->channels());
        light[k] = system_->value(values_, k);
        errors[k] = CutTest::standard_error(gathering_, cut_.rows[k], *system_, radiosity);
    };
    parallel_for(cut_.rows.size(), 64, gather_one, starting);
    // Not where rays find a constant sky: what they miss of it they find of surfaces, and both together err less.
    if (!gathering_.has_sky())
        light = system_->keep_power(light, without_noise(*field_, light, errors, sight_, starting, tuning_.regression));
    for (std::size_t k = 0; k < light.size(); ++k) at_nodes[k].value = light[k];
    out_.irradiance = at_leaves(std::move(at_nodes));
    if (gathering_.has_sky()) {
        at_nodes.resize(cut_.rows.size());
        for (std::size_t k = 0; k < cut_.rows.size(); ++k) at_nodes[k] = system_->tilted_sky(k);
        out_.direct = at_leaves(std::move(at_nodes));
    }
    field_.reset();
    system_.reset();
    out_.direct.resize(leaves.size());
    out_.levels.resize(leaves.size());
    out_.cut.resize(leaves.size());
    out_.emitted = sources_.from_emitters(leaves);
    const auto write_one = [&](std::size_t k) {
        out_.direct[k] += sources_.from_lights(leaves[k]);
        out_.irradiance[k] += out_.direct[k] + sources_.from_emitters(leaves[k]);
        out_.cut[k] = cut_.place_of[leaves[k]];
        out_.levels[k] = tree_.level(cut_.nodes[out_.cut[k]]);
    };
    parallel_for(leaves.size(), 1024, write_one, standing_at(1, 1, stage("interpolation")));
}

}  // namespace

void solve_by_gathering(const Scene& scene, const Tracer& tracer, const RefinementOptions& options,
                        const StageProgress& progress, Solution& out) {
    Stopwatch watch(out.timings);
    const Sight sight(tracer, scene);
    const Progress of_tree = progress ? progress("hierarchy") : Progress{};
    SurfelTree tree(
        scene,
        build_hierarchy(scene, sight, {options.epsilon, 0, options.seed, options.tuning.least_shrinking}, of_tree),
        leaves_allowed(scene, options.insert, options.max_surfels), of_tree, options.tuning);
    watch.lap("hierarchy");
    GlobalRefinement(scene, tracer, sight, tree, options, progress, watch, out).run();
    give_back_memory();
    write_leaves(tree, tree.all_leaves(), out, progress ? progress("interpolation") : Progress{});
    watch.lap("interpolation");
}

}  // namespace surflux
