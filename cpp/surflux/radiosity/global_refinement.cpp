#include "surflux/radiosity/global_refinement.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/aimed.h"
#include "surflux/radiosity/gathered_system.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/nodal_field.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr std::size_t first_nodes = 200;
constexpr int most_iterations = 16, most_applications = 100, most_insertions = 6, indirect_insertions = 2;
constexpr std::size_t tested_neighbors = 9;
constexpr double smallest_share = 0.125;  // of the RMS radius of surfels, by area: no child is smaller
constexpr double sure = 2.0;              // standard errors that a difference must be beyond

double luminance(const Rgb& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

bool is_grey(const std::vector<Rgb>& values) {
    return std::all_of(values.begin(), values.end(), [](const Rgb& c) { return c.x == c.y && c.y == c.z; });
}

double smallest_radius(const Surfels& s) {
    double sum = 0.0, area = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) sum += s.areas[i] * s.radii[i] * s.radii[i], area += s.areas[i];
    return smallest_share * std::sqrt(sum / area);
}

class GlobalRefinement {
public:
    GlobalRefinement(const Scene& scene, const Tracer& tracer, const RefinementOptions& options,
                     const StageProgress& progress, Solution& out)
        : scene_(scene),
          tracer_(tracer),
          options_(options),
          progress_(progress),
          out_(out),
          watch_(out.timings),
          emitters_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::surfels),
          skies_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::sky),
          tree_(scene, build_hierarchy(scene.surfels, scene.object, {options.epsilon, 0, options.seed}, stage("hierarchy")),
                room()),
          gathering_(scene, tracer, tree_, emitters_, skies_, {options.rays, options.seed}),
          insertion_(scene, tree_, {0.3, 5, smallest_radius(scene.surfels)}) {
        watch_.lap("hierarchy");
        light_up(places_of(scene.surfels), stage("direct"));
        watch_.lap("direct");
        const bool grey = is_grey(scene.surfels.reflectance) && is_grey(scene.surfels.emission) &&
                          is_grey(sources_.lights) && is_grey(sources_.sky) && skies_.empty();
        system_ = std::make_unique<GatheredSystem>(tree_, gathering_, sources_, !emitters_.empty(), grey ? 1 : 3);
    }

    void run() {
        const auto [from, to] = tree_.level_of_at_least(first_nodes);
        for (std::uint32_t node = from; node < to; ++node) cut_.nodes.push_back(node);
        find_places();
        solve_on_nodes(0);
        if (options_.insert && insert_for_sources()) solve_on_nodes(0);
        for (int iteration = 0; iteration < most_iterations; ++iteration) {
            const std::size_t refined = replace(nodes_to_replace());
            if (refined == 0) break;
            solve_on_nodes(refined);
        }
        solve_smoothly();
        for (int round = 0; options_.insert && round < indirect_insertions && insert_for_indirect(); ++round)
            solve_smoothly();
        write();
    }

private:
    static constexpr std::uint32_t none = SurfelTree::none;

    Progress stage(const char* name) const { return progress_ ? progress_(name) : Progress{}; }
    std::size_t room() const {
        if (!options_.insert) return scene_.surfels.size();
        return options_.max_surfels > 0 ? options_.max_surfels : 2 * scene_.surfels.size();
    }

    // Sources of more points.
    void light_up(const std::vector<Place>& places, const Progress& progress) {
        const auto append = [](std::vector<Rgb>& to, const std::vector<Rgb>& more) {
            to.insert(to.end(), more.begin(), more.end());
        };
        std::vector<Rgb> errors;
        append(sources_.lights,
               direct_irradiance(scene_, tracer_, places, options_.direct, options_.seed, progress, &errors));
        for (const Rgb& error : errors) noise_.push_back(luminance(error));
        append(sources_.emitters,
               aimed_irradiance(scene_, tracer_, emitters_, places, options_.direct, options_.seed, progress));
        append(sources_.sky,
               aimed_irradiance(scene_, tracer_, skies_, places, options_.direct, options_.seed + 1, progress));
    }

    Place place(std::uint32_t point) const {
        return {tree_.position(point), tree_.normal(point), tree_.surfel(point), !tree_.is_inserted(point)};
    }

    // Rays of nodes that have none yet. Those of nodes that stay, and of the surfels that stand for a group and then
    // for themselves, are kept.
    void shoot() {
        std::vector<Place> fresh;
        cut_.rows.resize(cut_.nodes.size());
        row_of_.resize(tree_.points(), none);
        for (std::size_t k = 0; k < cut_.nodes.size(); ++k) {
            const std::uint32_t p = tree_.representative(cut_.nodes[k]);
            if (row_of_[p] == none) {
                row_of_[p] = static_cast<std::uint32_t>(gathering_.size() + fresh.size());
                fresh.push_back(place(p));
            }
            cut_.rows[k] = row_of_[p];
        }
        gathering_.add(fresh, stage("gathering"));
        watch_.lap("gathering");
    }

    void solve_on_nodes(std::size_t refined) {
        shoot();
        system_->take_by_nodes(cut_);
        report(system_->solve(options_.tolerance, most_applications, values_, stage("solve")), refined);
        double sum = 0.0, area = 0.0;
        for (std::uint32_t p = 0; p < tree_.points(); ++p) {
            if (!tree_.is_leaf(p)) continue;
            const double h = luminance(system_->irradiance(p, values_));
            sum += tree_.area(p) * h * h;
            area += tree_.area(p);
        }
        reference_ = std::sqrt(sum / area);
        watch_.lap("solve");
    }

    void report(const LinearReport& linear, std::size_t refined) {
        out_.history.push_back({{"surfels", static_cast<double>(tree_.leaves())},
                                {"cut", static_cast<double>(cut_.nodes.size())},
                                {"refined", static_cast<double>(refined)},
                                {"inserted", static_cast<double>(tree_.points() - scene_.surfels.size())},
                                {"links", static_cast<double>(gathering_.links())},
                                {"rays", static_cast<double>(gathering_.rays())},
                                {"channels", static_cast<double>(system_->channels())},
                                {"applications", static_cast<double>(linear.applications)},
                                {"residual", linear.residual}});
    }

    // Lighting of what was inserted from `first` on.
    void light_up_from(std::uint32_t first) {
        std::vector<Place> places;
        for (std::uint32_t p = first; p < tree_.points(); ++p) places.push_back(place(p));
        light_up(places, {});
    }

    // Borders of shadows, from what needs no solving.
    bool insert_for_sources() {
        const std::size_t before = tree_.leaves();
        for (int round = 0; round < most_insertions; ++round) {
            std::vector<double> values(tree_.points());
            for (std::size_t p = 0; p < values.size(); ++p) values[p] = luminance(sources_[p]);
            std::vector<double> wanted(values.size());
            for (std::size_t p = 0; p < values.size(); ++p) wanted[p] = options_.zeta * reference_ + sure * noise_[p];
            const std::uint32_t first = insertion_.refine(values, wanted);
            if (first == tree_.points()) break;
            light_up_from(first);
        }
        find_places();
        watch_.lap("insertion");
        return tree_.leaves() > before;
    }

    // Where the whole field is not what the leaves around say. A leaf that is a node itself has nodes for children.
    bool insert_for_indirect() {
        std::vector<double> values(tree_.points(), 0.0), wanted(tree_.points(), 0.0);
        for (std::uint32_t p = 0; p < tree_.points(); ++p) {
            if (!tree_.is_leaf(p)) continue;
            values[p] = luminance(system_->irradiance(p, values_));
            wanted[p] = options_.zeta * reference_ + sure * std::hypot(noise_[p], noise(cut_.place_of[p]));
        }
        const std::uint32_t first = insertion_.refine(values, wanted);
        if (first == tree_.points()) return false;
        light_up_from(first);
        std::vector<char> opened(cut_.nodes.size(), 0);
        for (std::size_t k = 0; k < cut_.nodes.size(); ++k)
            opened[k] = tree_.is_point(cut_.nodes[k]) && !tree_.is_leaf(cut_.nodes[k]) &&
                        tree_.first_child(cut_.nodes[k]) >= first;
        replace(opened);
        watch_.lap("insertion");
        shoot();
        return true;
    }

    // Standard error of a node's value.
    double noise(std::size_t k) const {
        double first[3], second[3];
        gathering_.gather_halves(cut_.rows[k], *sent_, system_->channels(), first, second);
        return 0.5 * std::abs(luminance(system_->unpack(first)) - luminance(system_->unpack(second)));
    }

    std::vector<char> nodes_to_replace() {
        std::vector<Vec3> positions, normals;
        std::vector<std::uint32_t> objects;
        for (std::uint32_t row : cut_.rows) {
            positions.push_back(gathering_.place(row).position);
            normals.push_back(gathering_.place(row).normal);
            objects.push_back(scene_.object[gathering_.place(row).surfel]);
        }
        const Interpolation nodes(positions, normals, objects);
        sent_ = &system_->sent(values_);
        const double wanted = options_.zeta * reference_;
        const auto value = [&](std::size_t k) { return luminance(system_->value(values_, k) + system_->found(k)); };
        std::vector<char> out(cut_.nodes.size(), 0);
        parallel_blocks(cut_.nodes.size(), 64, [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                if (tree_.is_leaf(cut_.nodes[k])) continue;
                // What is close changes the field within that distance (Ward and others 1988); to first order, by which
                // fields are interpolated, by the square of it.
                const double own = value(k);
                const double reach = std::sqrt(tree_.area(cut_.nodes[k]) / pi) * gathering_.row(cut_.rows[k]).closeness;
                if (own * reach * reach > wanted) {
                    out[k] = 1;
                    continue;
                }
                // What the nodes around would say here (D04 eq. 11, but for what is a slope).
                nodes.nearest(positions[k], normals[k], objects[k], tested_neighbors, near);
                double around = 0.0, sum = 0.0;
                const double h = near.empty() ? 0.0 : near.back().weight;
                for (const Interpolation::Weight& other : near) {
                    if (other.site == k || !(other.weight > 0.0) || other.weight >= h) continue;
                    const double root = (h - other.weight) / (h * other.weight);
                    around += root * root * value(other.site);
                    sum += root * root;
                }
                out[k] = !(sum > 0.0) || std::abs(own - around / sum) - sure * noise(k) > wanted;
            }
        });
        return out;
    }

    // Nodes give way to their members. How many did.
    std::size_t replace(const std::vector<char>& chosen) {
        const std::size_t channels = system_->channels();
        std::vector<std::uint32_t> next;
        std::vector<double> start;
        std::size_t count = 0;
        for (std::size_t k = 0; k < cut_.nodes.size(); ++k) {
            const auto keep = [&](std::uint32_t node) {
                next.push_back(node);
                for (std::size_t c = 0; c < channels; ++c) start.push_back(values_[k * channels + c]);
            };
            count += chosen[k] != 0;
            if (chosen[k])
                tree_.for_members(cut_.nodes[k], keep);
            else
                keep(cut_.nodes[k]);
        }
        cut_.nodes = std::move(next);
        values_ = std::move(start);
        find_places();
        watch_.lap("refinement");
        return count;
    }

    void find_places() {
        cut_.place_of.assign(tree_.points(), none);
        std::vector<std::uint32_t> stack;
        for (std::uint32_t k = 0; k < cut_.nodes.size(); ++k) {
            stack.push_back(cut_.nodes[k]);
            while (!stack.empty()) {
                const std::uint32_t node = stack.back();
                stack.pop_back();
                if (tree_.is_point(node)) cut_.place_of[node] = k;
                tree_.for_members(node, [&](std::uint32_t member) { stack.push_back(member); });
            }
        }
    }

    void solve_smoothly() {
        shoot();
        std::vector<Place> places;
        std::vector<std::uint32_t> objects;
        for (std::uint32_t row : cut_.rows) {
            places.push_back(gathering_.place(row));
            objects.push_back(scene_.object[places.back().surfel]);
        }
        field_ = std::make_unique<NodalField>(std::move(places), std::move(objects));
        system_->interpolate(cut_, field_->interpolation());
        watch_.lap("interpolation");
        report(system_->solve(options_.tolerance, most_applications, values_, stage("solve")), 0);
        sent_ = &system_->sent(values_);
        watch_.lap("solve");
    }

    void write();

    const Scene& scene_;
    const Tracer& tracer_;
    const RefinementOptions& options_;
    const StageProgress& progress_;
    Solution& out_;
    Stopwatch watch_;
    const LightSampler emitters_, skies_;
    SurfelTree tree_;
    Gathering gathering_;
    Insertion insertion_;
    Sources sources_;
    std::unique_ptr<GatheredSystem> system_;
    Cut cut_;
    std::vector<std::uint32_t> row_of_;  // of points that stand for a node
    std::vector<double> values_;
    const std::vector<double>* sent_ = nullptr;
    std::vector<double> noise_;  // of the luminance of each point's sources
    double reference_ = 0.0;     // RMS of H
    std::unique_ptr<NodalField> field_;
};

// Of the leaves, each surfel's together.
void GlobalRefinement::write() {
    std::vector<TiltedRgb> from_surfels(cut_.rows.size()), from_sky(cut_.rows.size());
    parallel_for(cut_.rows.size(), 64, [&](std::size_t k) {
        TiltedRgb& light = from_surfels[k];
        light = gathering_.gather_tilted(cut_.rows[k], *sent_, system_->channels());
        light.value = system_->value(values_, k);
        const TiltedRgb& lamp = gathering_.lamps()[cut_.rows[k]];
        light.value += lamp.value;
        light.u += lamp.u;
        light.v += lamp.v;
        from_sky[k] = gathering_.sky()[cut_.rows[k]];
    });
    const NodalField::Values indirect = field_->fit(std::move(from_surfels)), sky = field_->fit(std::move(from_sky));

    std::vector<std::uint32_t> leaves;
    tree_.for_leaves([&](std::uint32_t p) { leaves.push_back(p); });
    out_.surfels = tree_.surfels_at(leaves);
    const std::size_t n = leaves.size();
    out_.parents.resize(n);
    out_.direct.resize(n);
    out_.irradiance.resize(n);
    out_.radiosity.resize(n);
    parallel_blocks(n, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Interpolation::Weight> near;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t p = leaves[k];
            const Vec3 &at = tree_.position(p), &normal = tree_.normal(p);
            field_->interpolation().at(at, normal, tree_.object(p), near);
            out_.parents[k] = tree_.surfel(p);
            out_.direct[k] = sources_.lights[p] + sources_.sky[p] + field_->at(sky, at, normal, near);
            out_.irradiance[k] = out_.direct[k] + sources_.emitters[p] + field_->at(indirect, at, normal, near);
            out_.radiosity[k] = tree_.emission(p) + tree_.reflectance(p) * out_.irradiance[k];
        }
    });
    watch_.lap("interpolation");
}

}  // namespace

void solve_by_gathering(const Scene& scene, const Tracer& tracer, const RefinementOptions& options,
                        const StageProgress& progress, Solution& out) {
    GlobalRefinement(scene, tracer, options, progress, out).run();
}

}  // namespace surflux
