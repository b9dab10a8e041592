#include "surflux/lights/light_sampled_irradiance.h"

#include <algorithm>
#include <optional>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_rays.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 0xa13ed, cosine_stream = 0xc051e, facet_stream = 0xface7,
                        group_stream = 0x9e3779b97f4a7c15;
// Where more than one in `close_share` hemisphere rays meets an emitter, there are `closer` times as many samples:
// close to emitters there is the most light, and the largest variance.
constexpr int close_share = 16, closer = 4;

constexpr double roulette = 0.25;
constexpr int fewest_probes = 16, fewest_rays = 64;  // of a group

// Irradiance of one place: of light samples, group by group, and of rays over the hemisphere, if there are any.
// Each kind has a mean of its own, for the balance heuristic holds whatever their numbers are.
class Shot {
public:
    Shot(bool over_hemisphere, const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
         const DirectOptions& options, std::uint64_t seed)
        : over_hemisphere_(over_hemisphere),
          tracer_(tracer),
          lights_(lights),
          points_(points),
          options_(options),
          seed_(seed),
          groups_(static_cast<std::size_t>(lights.groups())),
          facets_(over_hemisphere ? lights.facets() : nullptr) {}

    Rgb operator()(const Place& place) {
        if (facets_)
            if (const std::optional<Rgb> found = known_light(place)) return *found;
        const int groups = lights_.groups(),
                  few = std::max(std::min(fewest_probes, options_.probes), options_.probes / groups);
        EvenPoints even_cosine(4, seed_ + cosine_stream, stream_of(place));
        over_ = {};
        met_ = 0;
        shoot_over_hemisphere(place, even_cosine, options_.probes);
        Rgb out;
        const bool close = met_ > over_.taken / close_share;
        bool any = met_ > 0;
        double all = 0.0;  // that probes of groups which are lit would bring but for what blocks them
        for (int g = 0; g < groups; ++g) {
            Group& group = groups_[static_cast<std::size_t>(g)];
            group.begin(seed_ + light_stream, stream_of(place) + static_cast<std::uint64_t>(g) * group_stream);
            take(g, place, few, group);
            if (met_ > 0 || group.lit > 0) all += group.weight;
        }
        // Probes and further samples have a mean each, in fixed shares: whatever probes decide, the sum is right in the
        // mean. Of groups of which probes find nothing a share goes on, and speaks for the others: it may still arrive,
        // by a gap, and a light that none of them drew may be there, too.
        const int most = close ? closer * options_.rays : options_.rays;
        const double further = std::max(0.0, 1.0 - 1.0 * few / std::max(few, most));
        for (int g = 0; g < groups; ++g) {
            Group& group = groups_[static_cast<std::size_t>(g)];
            Rgb found = group.sum / group.taken;
            double scale = 0.0;
            int more = fewest_rays;
            if (met_ > 0 || (group.lit > 0 && (over_hemisphere_ || group.blocked > 1))) {
                any = true;
                more = std::max(few, share_of(most, all > 0.0 ? group.weight / all : 0.0) - few);
                scale = 1.0;
            } else if (group.lit == 0 && group.random->uniform() < roulette) {
                scale = 1.0 / roulette;
            }
            if (scale > 0.0 && further > 0.0) {
                group.sum = {};
                group.taken = 0;
                take(g, place, more, group);
                found = (1.0 - further) * found + (scale * further / group.taken) * group.sum;
            }
            out += found;
        }
        return over_hemisphere_ ? out + found_over_hemisphere(place, even_cosine, any, close) : out;
    }

private:
    // What facets bring, in closed form, times the share of light samples that arrive, which is noise in penumbrae
    // alone. Nothing where samples cannot tell: of a lamp that hardly rises over the horizon, or of one that is blocked
    // in part and so close that few of them have most of its light. Probes and further samples have a share each, as
    // above.
    std::optional<Rgb> known_light(const Place& place) {
        const int groups = lights_.groups(),
                  few = std::max(std::min(fewest_probes, options_.probes), options_.probes / groups);
        const bool close = facets_->form_factor(place.position, place.normal) * close_share >= 1.0;
        const int most = close ? closer * options_.rays : options_.rays;
        Rgb out;
        for (int g = 0; g < groups; ++g) {
            Group& group = groups_[static_cast<std::size_t>(g)];
            const std::uint64_t stream = stream_of(place) + static_cast<std::uint64_t>(g) * group_stream;
            const Rgb all = light_of_facets(g, place, stream);
            if (all == Rgb{}) continue;
            group.begin(seed_ + light_stream, stream);
            take_facets(g, place, few, group);
            if (group.lit + group.blocked == 0) return {};
            const bool agree = group.lit == 0 || group.blocked == 0;
            if (!agree && group.is_uneven()) return {};
            // Where all probes find the same a share of the places goes on, and what it finds beside that counts for
            // the others, which took it to be so.
            const Rgb probed = group.share();
            double scale = most > few ? 1.0 : 0.0;
            if (agree) scale *= group.random->uniform() < roulette ? 1.0 / roulette : 0.0;
            Rgb share = probed;
            if (scale > 0.0) {
                const double further = 1.0 - 1.0 * few / most;
                group.forget();
                take_facets(g, place, agree ? options_.rays : most, group);
                if (group.lit + group.blocked > 0) share += scale * further * (group.share() - probed);
            }
            for (int c = 0; c < 3; ++c) out[c] += std::max(0.0, share[c]) * all[c];
        }
        return out;
    }

    // What they all would bring, and of_facets_, by which samples are drawn: means over the patch of a place, of more
    // points where it changes much.
    Rgb light_of_facets(int g, const Place& place, std::uint64_t stream) {
        constexpr int few = 16, more = 64, many = 256;
        constexpr double some = 0.025, much = 0.1;  // standard deviation, over the mean
        of_facets_.assign(facets_->end_of(g) - facets_->first_of(g), {});
        EvenPoints even(2, seed_ + facet_stream, stream);
        const bool is_patch = place.shape != Place::point && points_.is_patch(place.shape);
        int taken = 0;
        double sum = 0.0, squares = 0.0;
        const auto take = [&](int count) {
            for (; taken < count; ++taken) {
                const double* u = even.next();
                const Vec3 at = is_patch ? points_.at(place, u[0], u[1]) : place.position;
                double here = 0.0;
                for (std::uint32_t f = 0; f < of_facets_.size(); ++f) {
                    const Rgb brings = facets_->irradiance(facets_->first_of(g) + f, at, place.normal);
                    of_facets_[f] += brings;
                    here += brightness(brings);
                }
                sum += here, squares += here * here;
            }
        };
        take(is_patch ? is_cut_by_horizon(g, place) ? many : few : 1);
        const auto varies = [&](double by) { return taken * squares > (1.0 + by * by) * sum * sum; };
        if (varies(some)) take(more);
        if (varies(much)) take(many);
        all_ = {};
        for (const Rgb& brings : of_facets_) all_ += brings / taken;
        up_to_.clear();
        for (const Rgb& brings : of_facets_) {
            up_to_.push_back((up_to_.empty() ? 0.0 : up_to_.back()) + share_of_all(brings));
        }
        for (double& up_to : up_to_) up_to /= up_to_.back();
        return all_;
    }

    // Do some corners of a patch see something of the facets, and others nothing?
    bool is_cut_by_horizon(int g, const Place& place) const {
        int seeing = 0;
        for (int corner = 0; corner < 4; ++corner) {
            const Vec3 at = points_.at(place, corner % 2, corner / 2);
            bool sees = false;
            for (std::uint32_t f = facets_->first_of(g); f < facets_->end_of(g) && !sees; ++f)
                sees = brightness(facets_->irradiance(f, at, place.normal)) > 0.0;
            seeing += sees;
        }
        return seeing > 0 && seeing < 4;
    }

    // Each channel counts alike, however dim: its light is what samples say of it.
    double share_of_all(const Rgb& brings) const {
        double sum = 0.0;
        for (int c = 0; c < 3; ++c) sum += all_[c] > 0.0 ? brings[c] / all_[c] : 0.0;
        return sum;
    }

    struct Sum {
        Rgb sum;
        int taken = 0;
    };
    struct Group : Sum {
        int lit = 0, blocked = 0;
        double weight = 0.0;   // of what samples would bring but for what blocks them
        Rgb passed, sent;      // of samples of facets, that arrive and of all
        double squares = 0.0;  // of their weights
        std::optional<EvenPoints> even;
        std::optional<Random> random;
        void begin(std::uint64_t seed, std::uint64_t stream) {
            *this = {};
            even.emplace(4, seed, stream);
            random.emplace(seed, stream);
        }
        // By channel, for facets have colours of their own.
        Rgb share() const {
            Rgb out;
            for (int c = 0; c < 3; ++c)
                out[c] = sent[c] > 0.0 ? passed[c] / sent[c] : static_cast<double>(lit) / (lit + blocked);
            return out;
        }
        // Are samples worth less than half as many of one weight (Kish's effective sample size)?
        bool is_uneven() const { return 2.0 * weight * weight < static_cast<double>(taken) * squares; }
        void forget() { passed = sent = {}, weight = squares = 0.0, lit = blocked = taken = 0; }
    };

    // Of all rays, by powers of 2, which are the evenest.
    static int share_of(int rays, double share) {
        int out = rays;
        while (out / 2 >= std::max(fewest_rays, static_cast<int>(share * rays))) out /= 2;
        return out;
    }

    // The same of rays over the hemisphere, of which probes have been shot. Their share is that which they have where
    // there are the most.
    Rgb found_over_hemisphere(const Place& place, EvenPoints& even, bool any, bool close) {
        const int most = closer * options_.rays, wanted = close ? most : options_.rays;
        const double further = std::max(0.0, 1.0 - 1.0 * options_.probes / std::max(options_.probes, most));
        const Rgb found = over_.sum / over_.taken;
        const double scale = any ? 1.0 : groups_.front().random->uniform() < roulette ? 1.0 / roulette : 0.0;
        if (!(scale * further > 0.0)) return found;
        over_ = {};
        shoot_over_hemisphere(place, even, std::max(options_.probes, wanted - options_.probes));
        return (1.0 - further) * found + (scale * further / over_.taken) * over_.sum;
    }

    void shoot_over_hemisphere(const Place& place, EvenPoints& even, int count) {
        if (!over_hemisphere_) return;
        const Frame frame = frame_around(place.normal);
        rays_.clear();
        for (; over_.taken < count; ++over_.taken) {
            const double* u = even.next();
            rays_.push_back({{points_.at(place, u[2], u[3]), place.normal, place.surfel},
                             frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
        }
        tracer_.closest(rays_, hits_);
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            if (!hits_[r].front) continue;
            const Rgb found = lights_.found_at_end(place.normal, rays_[r].direction, hits_[r]);
            if (!(found == Rgb{})) ++met_;
            over_.sum += found;
        }
    }

    void take(int g, const Place& place, int count, Group& group) {
        light_.clear();
        gain_.clear();
        for (; group.taken < count; ++group.taken) {
            const double* u = group.even->next();
            const Vec3 from = points_.at(place, u[2], u[3]);
            const LightRay ray = lights_.sample(from, place.normal, u[0], u[1], group.random->uniform(), g);
            if (!(ray.length > 0.0)) continue;
            light_.add({from, place.normal, place.surfel}, ray);
            gain_.push_back(ray.irradiance);
            group.weight += brightness(ray.irradiance);
        }
        const std::vector<char>& arrives = light_.trace(tracer_);
        for (std::size_t r = 0; r < gain_.size(); ++r) {
            (arrives[r] ? group.lit : group.blocked) += 1;
            if (arrives[r]) group.sum += gain_[r];
        }
    }

    void take_facets(int g, const Place& place, int count, Group& group) {
        light_.clear();
        whole_.clear();
        for (; group.taken < count; ++group.taken) {
            const double* u = group.even->next();
            const Vec3 from = points_.at(place, u[2], u[3]);
            const auto facet = std::upper_bound(up_to_.begin(), up_to_.end() - 1, u[0]);
            const double below = facet == up_to_.begin() ? 0.0 : facet[-1], share = *facet - below;
            const std::uint32_t f = facets_->first_of(g) + static_cast<std::uint32_t>(facet - up_to_.begin());
            const EmissiveFacets::Sample to = facets_->sample(f, std::clamp((u[0] - below) / share, 0.0, 1.0), u[1]);
            const Rgb brings = facets_->irradiance(f, to, from, place.normal) / share;
            if (brings == Rgb{}) continue;
            light_.add({from, place.normal, place.surfel},
                       {normalized(to.place - from), Ray{}.length, brings, to.surfel});
            whole_.push_back(brings);
        }
        const std::vector<char>& arrives = light_.trace(tracer_);
        for (std::size_t r = 0; r < whole_.size(); ++r) {
            (arrives[r] ? group.lit : group.blocked) += 1;
            group.sent += whole_[r];
            const double weight = share_of_all(whole_[r]);
            group.weight += weight;
            group.squares += weight * weight;
            if (arrives[r]) group.passed += whole_[r];
        }
    }

    bool over_hemisphere_;
    const Tracer& tracer_;
    const LightSampler& lights_;
    const SurfelPoints& points_;
    const DirectOptions& options_;
    const std::uint64_t seed_;
    std::vector<Group> groups_;
    const EmissiveFacets* facets_;
    Sum over_;
    int met_ = 0;
    std::vector<Ray> rays_;
    LightRays light_;
    std::vector<Rgb> gain_;
    std::vector<Rgb> of_facets_;  // of a group: what each brings, summed over points of a place
    Rgb all_;                     // the same of all of them, the mean
    std::vector<double> up_to_;   // the share of that, up to and with each
    std::vector<Rgb> whole_;      // what samples of facets bring
    std::vector<Hit> hits_;
};

std::vector<Rgb> irradiance_of(bool over_hemisphere, const Tracer& tracer, const LightSampler& lights,
                               const SurfelPoints& points, const std::vector<Place>& places,
                               const DirectOptions& options, std::uint64_t seed, const Progress& progress) {
    std::vector<Rgb> out(places.size());
    if (lights.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Shot shot(over_hemisphere, tracer, lights, points, options, seed);
            for (std::size_t k = begin; k < end; ++k) out[k] = shot(places[k]);
        },
        progress);
    return out;
}

}  // namespace

std::vector<Rgb> light_sampled_irradiance(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                                          const std::vector<Place>& places, const DirectOptions& options,
                                          std::uint64_t seed, const Progress& progress) {
    return irradiance_of(false, tracer, lights, points, places, options, seed, progress);
}

std::vector<Rgb> emitted_irradiance(const Tracer& tracer, const LightSampler& emitters, const SurfelPoints& points,
                                    const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                    const Progress& progress) {
    return irradiance_of(true, tracer, emitters, points, places, options, seed, progress);
}

}  // namespace surflux
