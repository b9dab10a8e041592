#include "surflux/radiosity/global_refinement.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/radiosity/gathered_system.h"
#include "surflux/radiosity/insertion.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr std::size_t first_nodes = 200;
constexpr int most_iterations = 16, most_applications = 100, most_insertions = 6, indirect_insertions = 1;
constexpr std::size_t tested_neighbors = 9;
constexpr double usual_share = 0.25;  // of the mean area of surfels, by area
constexpr int probe_rays = 32;
constexpr double probe_error = 0.08;  // of what they find, at least
constexpr std::uint64_t probe_stream = 0x9706e;
constexpr double rough_tolerance = 1e-2;  // of solutions that are refined
constexpr double little = 1e-3;           // of the surface: not worth another iteration
constexpr double most_unlike = 32.0;      // areas of nodes beside each other
constexpr double sure = 2.0;  // standard errors that a difference must be beyond

bool is_grey(const std::vector<Rgb>& values) {
    return std::all_of(values.begin(), values.end(), [](const Rgb& c) { return c.x == c.y && c.y == c.z; });
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
                leaves_allowed(scene, options.insert, options.max_surfels)),
          gathering_(scene, tracer, tree_, emitters_, skies_, options.seed),
          probes_(scene, tracer, tree_, emitters_, skies_, options.seed + probe_stream),
          insertion_(scene, tree_, {smallest_radius(scene.surfels)}),
          sources_(scene, tracer, tree_, &emitters_, &skies_, options.direct, options.seed) {
        double squared = 0.0, total = 0.0;
        for (double area : scene.surfels.areas) squared += area * area, total += area;
        usual_area_ = usual_share * squared / total;
        watch_.lap("hierarchy");
        sources_.update(stage("direct"));
        watch_.lap("direct");
        const bool grey = is_grey(scene.surfels.reflectance) && is_grey(scene.surfels.emission) &&
                          sources_.is_grey() && grey_skies();
        system_ = std::make_unique<GatheredSystem>(tree_, gathering_, sources_, !emitters_.empty(), grey ? 1 : 3);
    }

    void run() {
        const auto [from, to] = tree_.level_of_at_least(first_nodes);
        for (std::uint32_t node = from; node < to; ++node) cut_.nodes.push_back(node);
        find_places();
        solve_on_nodes(0);
        if (options_.insert && insert_for_sources()) solve_on_nodes(0);
        for (int iteration = 0; iteration < most_iterations; ++iteration) {
            const std::vector<char> chosen = nodes_to_replace();
            double area = 0.0, total = 0.0;
            for (std::size_t k = 0; k < chosen.size(); ++k) {
                const double of_node = tree_.area(cut_.nodes[k]);
                area += chosen[k] ? of_node : 0.0;
                total += of_node;
            }
            if (!(area > 0.0)) break;
            solve_on_nodes(replace(chosen));
            if (area < little * total) break;
        }
        solve_smoothly();
        for (int round = 0; options_.insert && round < indirect_insertions && insert_for_indirect(); ++round)
            solve_smoothly();
        write();
    }

private:
    static constexpr std::uint32_t none = SurfelTree::none;

    Progress stage(const char* name) const { return progress_ ? progress_(name) : Progress{}; }
    // Where the nodes of the cut are.
    struct Nodes {
        std::vector<Vec3> positions, normals;
        std::vector<std::uint32_t> objects;
        explicit Nodes(const GlobalRefinement& of) {
            for (std::uint32_t node : of.cut_.nodes) {
                const std::uint32_t p = of.tree_.representative(node);
                positions.push_back(of.tree_.position(p));
                normals.push_back(of.tree_.normal(p));
                objects.push_back(of.tree_.object(p));
            }
        }
    };

    // The error of all is least for given rays where they go by the root of the area.
    int rays_of(std::uint32_t node) const {
        const double share = std::sqrt(tree_.area(node) / usual_area_);
        int rays = options_.rays;
        for (double least = 0.7; share < least && rays > std::max(16, options_.rays / 4); least *= 0.5) rays /= 2;
        return rays;
    }

    // Rays of nodes that have none yet. Those of nodes that stay, and of the surfels that stand for a group and then
    // for themselves, are kept.
    void shoot() {
        std::vector<Place> fresh;
        std::vector<int> counts;
        cut_.rows.resize(cut_.nodes.size());
        row_of_.resize(tree_.points(), none);
        for (std::size_t k = 0; k < cut_.nodes.size(); ++k) {
            const std::uint32_t p = tree_.representative(cut_.nodes[k]);
            if (row_of_[p] == none) {
                row_of_[p] = static_cast<std::uint32_t>(gathering_.size() + fresh.size());
                fresh.push_back(LitPoints::place(tree_, p));
                counts.push_back(rays_of(cut_.nodes[k]));
            }
            cut_.rows[k] = row_of_[p];
        }
        gathering_.add(fresh, counts, stage("gathering"));
        watch_.lap("gathering");
    }

    void solve_on_nodes(std::size_t refined) {
        shoot();
        system_->take_by_nodes(cut_);
        report(system_->solve(std::max(rough_tolerance, options_.tolerance), most_applications, values_, stage("solve")), refined);
        watch_.lap("solve");
    }

    bool grey_skies() const {
        return std::all_of(scene_.lights.begin(), scene_.lights.end(), [](const Light& light) {
            const auto* sky = std::get_if<Environment>(&light);
            return !sky || (sky->pixels.empty() && is_grey({sky->radiance}));
        });
    }

    // What this iteration came to.
    void report(const LinearReport& linear, std::size_t refined) {
        sent_ = &system_->sent(values_);
        Rgb entered, absorbed, escaped, backs;
        double squared = 0.0, total = 0.0;
        for (std::uint32_t p = 0; p < tree_.points(); ++p) {
            if (!tree_.is_leaf(p)) continue;
            const double area = tree_.area(p);
            const Rgb &rho = tree_.reflectance(p), h = system_->irradiance(p, values_);
            const Rgb b = tree_.emission(p) + rho * h;
            const std::uint32_t row = cut_.rows[cut_.place_of[p]];
            entered += area * (sources_.from_lights(p) + gathering_.sky()[row].value + tree_.emission(p));
            absorbed += area * (Rgb{1, 1, 1} - rho) * h;
            escaped += (area * static_cast<double>(gathering_.row(row).escape)) * b;
            backs += (area * static_cast<double>(gathering_.row(row).absorbed)) * b;
            squared += area * luminance(h) * luminance(h);
            total += area;
        }
        reference_ = std::sqrt(squared / total);
        const auto sum = [](const Rgb& c) { return c.x + c.y + c.z; };
        out_.history.push_back({{"surfels", static_cast<double>(tree_.leaves())},
                                {"cut", static_cast<double>(cut_.nodes.size())},
                                {"refined", static_cast<double>(refined)},
                                {"inserted", static_cast<double>(tree_.points() - scene_.surfels.size())},
                                {"links", static_cast<double>(gathering_.links())},
                                {"rays", static_cast<double>(gathering_.rays() + probes_.rays())},
                                {"channels", static_cast<double>(system_->channels())},
                                {"applications", static_cast<double>(linear.applications)},
                                {"residual", linear.residual},
                                {"power_in", sum(entered)},
                                {"power_absorbed", sum(absorbed)},
                                {"power_escaped", sum(escaped)},
                                {"power_into_backs", sum(backs)}});
    }

    // Borders of shadows, from what needs no solving.
    bool insert_for_sources() {
        const std::size_t before = tree_.leaves();
        const auto source = [&](std::uint32_t p) { return luminance(sources_[p]); };
        const auto wanted = [&](std::uint32_t p) { return options_.zeta * reference_ + sure * sources_.noise(p); };
        for (int round = 0; round < most_insertions && insertion_.refine(source, wanted); ++round) sources_.update();
        find_places();
        watch_.lap("insertion");
        return tree_.leaves() > before;
    }

    // Where the whole field is not what the leaves around say.
    bool insert_for_indirect() {
        const auto first = static_cast<std::uint32_t>(tree_.points());
        const auto all = [&](std::uint32_t p) { return luminance(system_->irradiance(p, values_)); };
        const auto wanted = [&](std::uint32_t p) {
            return options_.zeta * reference_ + sure * std::hypot(sources_.noise(p), noise(cut_.place_of[p]));
        };
        if (!insertion_.refine(all, wanted)) return false;
        sources_.update();
        for (bool any = true; any;) {
            find_places();
            std::vector<char> opened(cut_.nodes.size(), 0);
            for (std::uint32_t point = first; point < tree_.points(); ++point) {
                const std::uint32_t k = cut_.place_of[point];
                if (k != none && !tree_.is_leaf(cut_.nodes[k])) opened[k] = 1;
            }
            any = replace(opened) > 0;
        }
        for (int round = 0; round < most_iterations && replace(unbalanced()) > 0; ++round) {
        }
        watch_.lap("insertion");
        shoot();
        return true;
    }

    // Nodes much larger than one beside them: between the two the finer side would have all the say.
    std::vector<char> unbalanced() const {
        const Nodes at(*this);
        const Interpolation nodes(at.positions, at.normals, at.objects);
        std::vector<char> out(cut_.nodes.size(), 0);
        parallel_blocks(cut_.nodes.size(), 64, [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                if (tree_.is_leaf(cut_.nodes[k])) continue;
                nodes.nearest(at.positions[k], at.normals[k], at.objects[k], tested_neighbors, near);
                const double least = tree_.area(cut_.nodes[k]) / most_unlike;
                out[k] = std::any_of(near.begin(), near.end(), [&](const Interpolation::Weight& other) {
                    return tree_.area(cut_.nodes[other.site]) < least;
                });
            }
        });
        return out;
    }

    // Standard error of a node's value.
    double noise(std::size_t k) const {
        double first[3], second[3];
        gathering_.gather_halves(cut_.rows[k], *sent_, system_->channels(), first, second);
        return 0.5 * std::abs(luminance(system_->unpack(first)) - luminance(system_->unpack(second)));
    }

    std::vector<char> nodes_to_replace() {
        probe();
        const Nodes at(*this);
        const Interpolation nodes(at.positions, at.normals, at.objects);
        const double wanted = options_.zeta * reference_;
        const auto value = [&](std::size_t k) { return luminance(system_->value(values_, k) + system_->found(k)); };
        std::vector<char> out(cut_.nodes.size(), 0);
        std::vector<double> squared(cut_.nodes.size(), 0.0);
        parallel_blocks(cut_.nodes.size(), 64, [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                const double area = tree_.area(cut_.nodes[k]), spread = noise(k);
                squared[k] = area * spread * spread;
                if (tree_.is_leaf(cut_.nodes[k])) continue;
                // What is close changes the field within that distance (Ward and others 1988); to first order, by which
                // fields are interpolated, by the square of it.
                const double own = value(k);
                const double reach = std::sqrt(area / pi) * gathering_.row(cut_.rows[k]).closeness;
                // What the nodes around would say here (D04 eq. 11, but for what is a slope).
                nodes.nearest(at.positions[k], at.normals[k], at.objects[k], tested_neighbors, near);
                double around = 0.0, sum = 0.0;
                const double h = near.empty() ? 0.0 : near.back().weight;
                for (const Interpolation::Weight& other : near) {
                    if (other.site == k || !(other.weight > 0.0) || other.weight >= h) continue;
                    const double root = (h - other.weight) / (h * other.weight);
                    around += root * root * value(other.site);
                    sum += root * root;
                }
                around = sum > 0.0 ? around / sum : 0.0;
                static const double close_factor = std::getenv("SF_A") ? std::atof(std::getenv("SF_A")) : 1.0;
                const double close_by = close_factor * std::max(own, around) * reach * reach;
                const double off = std::max(std::abs(own - around), probed_off(k, nodes, value)) - sure * spread;
                out[k] = std::max(close_by, off) > wanted;
                const double left = 0.25 * std::max(0.0, off);  // of it, with nodes on all sides
                squared[k] += area * left * left;
            }
        });
        double sum = 0.0, total = 0.0;
        for (std::size_t k = 0; k < squared.size(); ++k) sum += squared[k], total += tree_.area(cut_.nodes[k]);
        out_.history.back().emplace_back("error", std::sqrt(sum / total) / reference_);
        return out;
    }

    // By how much the field is off at another surfel of the node, as far as a few rays can tell.
    template <class Value>
    double probed_off(std::size_t k, const Interpolation& nodes, const Value& value) const {
        const std::uint32_t row = probe_of_.at(cut_.nodes[k]);
        const Place& at = probes_.place(row);
        thread_local std::vector<Interpolation::Weight> weights;
        nodes.at(at.position, at.normal, scene_.object[at.surfel], weights);
        double said = 0.0;
        for (const Interpolation::Weight& w : weights) said += w.weight * value(w.site);
        double first[3], second[3];
        probes_.gather_halves(row, *sent_, system_->channels(), first, second);
        const double found = luminance(probes_.lamps()[row].value + probes_.sky()[row].value);
        const double a = luminance(system_->unpack(first)), b = luminance(system_->unpack(second));
        const double seen = found + 0.5 * (a + b), spread = std::max(0.5 * std::abs(a - b), probe_error * seen);
        return std::abs(seen - said) - sure * spread;
    }

    // Probes of groups that have none yet: rays from a surfel of theirs drawn by chance.
    void probe() {
        std::vector<Place> fresh;
        for (const std::uint32_t node : cut_.nodes) {
            if (tree_.is_leaf(node) || probe_of_.count(node)) continue;
            Random random(options_.seed + probe_stream, node);
            std::uint32_t p = node;
            while (!tree_.is_leaf(p)) {
                double left = random.uniform() * tree_.area(p);
                std::uint32_t next = p;
                tree_.for_members(p, [&](std::uint32_t member) {
                    if (left >= 0.0) next = member;
                    left -= tree_.area(member);
                });
                p = next;
            }
            probe_of_[node] = static_cast<std::uint32_t>(probes_.size() + fresh.size());
            fresh.push_back(LitPoints::place(tree_, p));
        }
        probes_.add(fresh, std::vector<int>(fresh.size(), probe_rays), stage("gathering"));
        watch_.lap("gathering");
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
        Nodes nodes(*this);
        field_ = std::make_unique<NodalField>(std::move(nodes.positions), std::move(nodes.normals),
                                              std::move(nodes.objects));
        system_->interpolate(cut_, field_->interpolation());
        watch_.lap("interpolation");
        report(system_->solve(options_.tolerance, most_applications, values_, stage("solve")), 0);
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
    Gathering gathering_, probes_;
    Insertion insertion_;
    LitPoints sources_;
    std::unique_ptr<GatheredSystem> system_;
    Cut cut_;
    std::unordered_map<std::uint32_t, std::uint32_t> probe_of_;  // of groups, their rows
    std::vector<std::uint32_t> row_of_;  // of points that stand for a node
    std::vector<double> values_;
    const std::vector<double>* sent_ = nullptr;
    double reference_ = 0.0;   // RMS of H
    double usual_area_ = 0.0;  // of a node that gets all rays
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
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t p = leaves[k];
            const Vec3 &at = tree_.position(p), &normal = tree_.normal(p);
            const Span<Interpolation::Weight> near = system_->weights(p);
            out_.parents[k] = tree_.surfel(p);
            out_.direct[k] = sources_.from_lights(p) + field_->at(sky, at, normal, near);
            out_.irradiance[k] = out_.direct[k] + sources_.from_emitters(p) + field_->at(indirect, at, normal, near);
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
