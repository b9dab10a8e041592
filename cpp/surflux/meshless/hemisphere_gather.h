#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/random.h"
#include "surflux/core/team.h"
#include "surflux/lights/aimed_row.h"
#include "surflux/lights/lit_patches.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/surface_light.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/meshless/tuning.h"

namespace surflux {

struct GatherOptions {
    double epsilon_omega = 0.314;  // solid angle below which a wide patch sends by its mean, and supports are small
    std::uint64_t seed = 0;
    MeshlessTuning tuning = {};
};

// Final gathering at points (GATHER of L07 6.3), kept as the rows of a sparse transport operator (L07 eq. 14): the rays
// of a point, cosine-distributed over its hemisphere, are shot once, and its row has what they met. Every bounce is
// then one sparse product, where L07 shoots anew. What a ray meets sends light in one of two ways. A surfel sends the
// mean of the field over it (surfel_means.h): the row has it as a sender. A wide patch that is near sends what the
// basis functions are at the ray's end, down to the level on which these are small as seen from there: the row has
// links to functions. Light that is not in the basis, of lamps or small emissive surfels (surface_light.h), needs no
// solving: rows have its first bounce as a number. It is found where these rays end and by next event estimation
// towards lit patches, combined by multiple importance sampling (Veach and Guibas 1995).
class HemisphereGather {
public:
    struct Link {
        std::uint32_t function;
        float share[3];  // of its coefficient: of the hemisphere, times reflectance
    };
    struct Row {
        double share = 0.0;                     // of the cosine-weighted hemisphere, that one unit stands for
        std::uint64_t rays = 0;                 // over it; of usual ones each is one unit
        Rgb sky;                                // that rays which left the scene found
        Rgb emitted;                            // from emissive surfels, as far as rays find it
        Rgb first_bounce;                       // of light beside the basis: light and hemisphere samples together
        Rgb halves;                             // of these three: one half of the samples less the other
        double escape = 0.0, into_backs = 0.0;  // shares of the hemisphere
        // Factors that follow from those of the columns, 1 before (gather_scaling.cpp). gather() applies `scale` to
        // senders' means and `linked_scale` to links; its callers apply `first_scale` to first_bounce, `emitted_scale`
        // to emitted and `power_scale` to what gather() returns, as once() has done for its rows.
        double scale = 1.0, linked_scale = 1.0, first_scale = 1.0, emitted_scale = 1.0, power_scale = 1.0;
        double met() const { return 1.0 - escape - into_backs; }
        // What escapes is part of the row, and is scaled with it.
        Rgb scaled_sky() const { return scale * sky; }
    };

    // Of what is gathered `basis` may have more levels later on: see extend().
    HemisphereGather(const Scene& scene, const Tracer& tracer, const SurfaceLight& light, const MultilevelBasis& basis,
                     const SurfelMeans& means, const GatherOptions& options, Team team = {});

    // Appends a row for each place, with as many rays as `counts` says.
    void add(const std::vector<Place>& places, const std::vector<int>& counts, const Progress& progress);
    // Some that are there, anew: with rays that are aimed at what is known to send (lights/aimed_row.h), about `count`
    // of each. `aims` gives what the k-th is to be aimed at.
    struct Shot {
        std::size_t row;
        Place place;
        int count;
    };
    using Aims = std::function<void(std::size_t k, std::vector<Aim>& out)>;
    void aim(const std::vector<Shot>& rows, const Aims& aims, const Progress& progress);
    // Where a place's rays end, as those of add(), and the luminance that comes from there.
    struct End {
        Vec3 at;  // or the direction, of skies
        double light;
        bool is_sky;
    };
    void ends(const Place& place, int count, const std::vector<Rgb>& sent, std::vector<End>& out) const;
    // Where rays would have gone on to a level that was not there yet, the links to it, now that it is.
    void extend(const Progress& progress);

    const Row& operator[](std::size_t row) const { return rows_[row].row; }
    std::size_t size() const { return rows_.size(); }
    // Calls visit(surfel, units) for what rays of a row met that sends, visit(function) for its links.
    template <class Visit>
    void for_senders(std::size_t row, const Visit& visit) const {
        for (const Sender& sender : rows_[row].senders) visit(sender.surfel, sender.units());
        for (const Sender& sender : rows_[row].linked) visit(sender.surfel, sender.units());
    }
    template <class Visit>
    void for_links(std::size_t row, const Visit& visit) const {
        for (const Link& link : rows_[row].links) visit(link.function);
    }
    // Calls visit(surfel, luminance) for what a row's first_bounce is made of, before any factor.
    template <class Visit>
    void for_lit(std::size_t row, const Visit& visit) const {
        for (const Lit& lit : rows_[row].lit) visit(lit.surfel, static_cast<double>(lit.luminance));
    }
    // Luminance of what a surfel sends of light that is not in the basis.
    double exitance(std::uint32_t surfel) const { return exitance_[surfel]; }
    double exitance_error(std::uint32_t surfel) const {
        return luminance(scene_.surfels.reflectance[surfel]) * light_.error_beside_basis(surfel);
    }
    // Emission that is not sampled as a light is found where hemisphere rays meet it, and is in Row::emitted; else
    // SurfaceLight has it, and rays that meet it count nothing.
    bool finds_emission(std::uint32_t surfel) const { return !light_.emitters().samples(surfel); }
    // Is a surfel kept as a sender in rows? Black ones are not, unless rays find emission there.
    bool sends(std::uint32_t surfel) const {
        const Surfels& s = scene_.surfels;
        return !(s.reflectance[surfel] == Rgb{}) || (finds_emission(surfel) && !(s.emission[surfel] == Rgb{}));
    }
    // Luminance that rays find of a surfel's emission.
    double emission(std::uint32_t surfel) const {
        return finds_emission(surfel) ? luminance(scene_.surfels.emission[surfel]) : 0.0;
    }
    // Column scaling of the operator (gather_scaling.cpp): what each surfel sends is multiplied by its factor; each row
    // is then scaled so that of uniform light it gathers what it did before.
    void set_sender_scale(std::vector<double> scale);
    // Further factors of each surfel, which conserve the power that it sends: of the light that is not in the basis
    // (`exitance`), of emission that rays find (`emitted`), and of the light in the basis (`reflected`), of which
    // surfels send about `radiosity`.
    struct SenderPower {
        std::vector<double> exitance, emitted, reflected, radiosity;
    };
    void set_sender_power(SenderPower power);
    std::size_t links() const { return links_; }
    std::size_t rays() const { return rays_; }
    // What each surfel sends of light in the basis: reflected, on the average over what of it is not inside geometry.
    void sent(const std::vector<Rgb>& coefficients, std::vector<Rgb>& out) const;
    // Irradiance of a row from all functions, of which surfels send `sent`.
    Rgb gather(std::size_t row, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent) const {
        return gather(rows_[row], coefficients, sent);
    }

    // Of what a row has and gathers, by halves of its rays: of a colour's norm.
    double standard_error(std::size_t row, const std::vector<Rgb>& sent) const;

    struct Once {
        Row row;
        Rgb gathered;
    };
    // Final gathering: a row for each place and the irradiance that it gathers, without keeping the row.
    std::vector<Once> once(const std::vector<Place>& places, const std::vector<int>& counts,
                           const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent,
                           const Progress& progress);
    // Drops all rows.
    void clear();

private:
    static constexpr std::uint64_t ray_stream = 0x6a71e4;

    // A ray's end at which the finest level so far was too coarse: to be linked to the next.
    struct OpenEnd {
        Vec3 position;
        std::uint32_t surfel;
        float distance;
        float share[3];
        float unused = 0.0f;  // no padding, which would be of any value where rows are packed
    };
    // What a surfel brings of the first bounce.
    struct Lit {
        std::uint32_t surfel;
        float luminance;
    };
    // A surfel that rays met, and their units in each half of them.
    struct Sender {
        std::uint32_t surfel;
        std::uint16_t first, second;
        double units() const { return first + second; }
    };
    struct Gathered {
        Row row;
        std::vector<Sender> senders, linked;  // those that send by their mean, and by functions; by surfel
        std::vector<Lit> lit;                 // by surfel
        std::vector<Link> links;
        std::vector<OpenEnd> open;
    };
    void shoot_all(const char* name, const std::vector<Shot>& rows, const Aims* aims, const Progress& progress);
    void scale_all();
    static void pack(const Gathered& row, std::size_t first_link, Packed& to);
    static void unpack(Unpacking& from, std::size_t first_link, Gathered& row);
    // Have rows from a place factors of energy? Many rays of a wide patch leave from under furniture and from beside
    // it: the factors of the senders under it are nothing to the others.
    bool has_factors(const Place& place) const { return !(place.is_whole_surfel() && means_.is_wide(place.surfel)); }
    Rgb gather_unscaled(const Gathered& row, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent) const;
    static Rgb gather_linked(const Gathered& row, const std::vector<Rgb>& coefficients);
    static Rgb gather(const Gathered& row, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent);
    class Sums;
    // aims: nullptr for evenly spread rays.
    void shoot(const Place& place, int count, const std::vector<Aim>* aims, Sums& sums, Gathered& out) const;
    void sample_lit_patches(const Place& place, int count, Random& random, Sums& sums) const;
    double mis_weight(const Ray& ray, const Hit& hit, int light_samples, const Sums& sums) const;
    void reflect(const Vec3& at, std::uint32_t surfel, double distance, double density, const Rgb& gain,
                 bool second_half, Random& random, Sums& sums) const;
    static void merge(std::vector<Sender>& senders);
    bool link(std::size_t first_level, const OpenEnd& end, Sums& sums) const;
    bool sends_by_mean(std::uint32_t surfel, double distance) const;
    void count_links();
    void scale(Gathered& row) const;

    const Scene& scene_;
    const Tracer& tracer_;
    const SurfaceLight& light_;
    const MultilevelBasis& basis_;
    const SurfelMeans& means_;
    GatherOptions options_;
    Team team_;
    std::vector<double> exitance_;  // of light that is not in the basis, luminance
    LitPatches lit_;
    std::vector<double> sender_scale_;  // empty: 1
    SenderPower sender_power_;          // empty: 1
    std::vector<Gathered> rows_;
    std::size_t links_ = 0, rays_ = 0, levels_ = 0;  // levels that rows are linked to
};

}  // namespace surflux
