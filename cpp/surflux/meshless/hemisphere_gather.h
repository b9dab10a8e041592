#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/random.h"
#include "surflux/lights/lit_patches.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/surface_light.h"
#include "surflux/meshless/surfel_means.h"

namespace surflux {

struct GatherOptions {
    double epsilon_omega = 0.314;  // solid angle below which a wide patch sends by its mean, and supports are small
    bool direct_in_basis = false;  // else what lights bring to senders is taken where rays meet them
    std::uint64_t seed = 0;
};

// GATHER of L07 6.3, as rows of the transport operator (L07 eq. 14): the irradiance of a point from what its rays meet,
// and what needs no solving. Surfels send by their means, but wide patches that are near by the basis functions where
// rays end, down to the level on which these are small as seen from there. Rays are shot once and kept as such rows:
// every bounce is one sparse product, where L07 shoots anew. Of lights that are not in the basis, rays aimed at patches
// that these shine on find the first bounce too.
class HemisphereGather {
public:
    struct Link {
        std::uint32_t function;
        float share[3];  // of its coefficient: of the hemisphere, times reflectance
    };
    struct Row {
        double share = 0.0;  // of the hemisphere, that a ray over it stands for
        Rgb sky;             // that rays which left the scene found
        Rgb emitted;         // from emissive surfels, as far as rays find it
        Rgb first;           // the first bounce of what lights bring to surfaces, and of what is aimed
        double noise = 0.0;  // standard error of all that, of its luminance
        double left = 0.0;   // share of the hemisphere that leaves the scene, or meets backs
    };

    // Of what is gathered `basis` may have more levels later on: see extend().
    HemisphereGather(const Scene& scene, const Tracer& tracer, const SurfaceLight& light, const MultilevelBasis& basis,
                     const SurfelMeans& means, const GatherOptions& options);

    // Appends a row for each place, with as many rays as `counts` says.
    void add(const std::vector<Place>& places, const std::vector<int>& counts, const Progress& progress);
    // Where rays would have gone on to a level that was not there yet, the links to it, now that it is.
    void extend(const Progress& progress);

    const Row& operator[](std::size_t row) const { return rows_[row].row; }
    std::size_t links() const { return links_; }
    std::size_t rays() const { return rays_; }
    // What each surfel sends of light in the basis: reflected, on the average over what of it is not inside geometry.
    void sent(const std::vector<Rgb>& coefficients, std::vector<Rgb>& out) const;
    // Irradiance of a row from all functions, of which surfels send `sent`.
    Rgb gather(std::size_t row, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent) const {
        return gather(rows_[row], coefficients, sent);
    }

    struct Once {
        Row row;
        Rgb gathered;
    };
    // A row for each place and what is gathered by it, without keeping it.
    std::vector<Once> once(const std::vector<Place>& places, const std::vector<int>& counts,
                           const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent,
                           const Progress& progress);
    // Forgets all rows.
    void clear();

private:
    // A ray's end for which the finest level there is was too coarse.
    struct OpenEnd {
        Vec3 position;
        std::uint32_t surfel;
        float distance;
        float share[3];
    };
    struct Gathered {
        Row row;
        std::vector<std::uint32_t> senders;  // surfels that rays met, once for each ray
        std::vector<Link> links;
        std::vector<OpenEnd> open;
    };
    static Rgb gather(const Gathered& row, const std::vector<Rgb>& coefficients, const std::vector<Rgb>& sent);
    class Sums;
    void shoot(const Place& place, int count, Sums& sums, Gathered& out) const;
    void aim(const Place& place, int aimed, Random& random, Sums& sums) const;
    double weight_beside_aimed(const Ray& ray, const Hit& hit, int aimed, const Sums& sums) const;
    void reflect(const Vec3& at, std::uint32_t surfel, double distance, const Rgb& gain, bool second_half,
                 Random& random, Sums& sums) const;
    bool link(std::size_t first_level, const OpenEnd& end, Sums& sums) const;
    bool sends_by_mean(std::uint32_t surfel, double distance) const;
    void count_links();

    const Scene& scene_;
    const Tracer& tracer_;
    const SurfaceLight& light_;
    const MultilevelBasis& basis_;
    const SurfelMeans& means_;
    GatherOptions options_;
    LitPatches lit_;
    std::vector<Gathered> rows_;
    std::size_t links_ = 0, rays_ = 0, levels_ = 0;  // levels that rows are linked to
};

}  // namespace surflux
