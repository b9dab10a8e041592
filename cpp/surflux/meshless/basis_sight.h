#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/sight.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Evaluation of a MultilevelBasis without light leaks: at a point on a surface only those basis functions have a weight
// whose own points it sees, by short shadow rays over the surface (Sight). L07 takes all whose supports reach it, and
// names leaks through walls as its limit. A shadow ray for each point and function would cost more than all else. So on
// each level a point looks for its anchor, the heaviest function that it sees, most often the first. Functions that see
// the anchor (adjacency, asked once for each pair and cached) are kept; about the others the point asks itself. Disks
// of a cloud stand off the surface that they stand for, so that many hide each other: there all functions are kept.
//   A nook is a part of the surface that sees no function of the coarsest level: behind walls, or narrower than the
// Poisson disks by which its points were placed. It gets a function of its own.
class BasisSight {
public:
    BasisSight(const Scene& scene, const Tracer& tracer, const MultilevelBasis& basis,
               const MeshlessTuning& tuning = {});

    // To be called when the basis has got a level, with the surfels that its points lie on, or none. After clear() it
    // may be another basis.
    void extend(const std::vector<std::uint32_t>& surfels, const Progress& progress);
    void clear();

    // MultilevelBasis::at_level of the functions that the point sees. If the surfel that it lies on (Hit::none: not
    // known) is in a nook, the nook's function alone.
    void at_level(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object, std::uint32_t surfel,
                  std::vector<BasisWeight>& out) const;
    // At the point of a function.
    void at_function(std::size_t level, std::uint32_t j, std::vector<BasisWeight>& out) const {
        at_level(level, basis_.position(j), basis_.normal(j), basis_.object(j), surfel_[j], out);
    }
    std::uint32_t surfel(std::uint32_t function) const { return surfel_[function]; }
    // Those of functions near a point that it sees; all of them, without a ray, where they see each other.
    void keep_seen_if_parted(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& weights) const;
    // Is a place that sees no function of points so far apart dark, as under furniture that stands a millimetre above
    // it?
    bool is_dark(const Vec3& point, const Vec3& normal, double spacing) const {
        return Sight::is_low(sight_.headroom(point, normal), spacing);
    }
    // The nooks among the places asked about, as indices of the places in each: those that see the nook's first place,
    // no farther away than the spacing of their object.
    std::vector<std::vector<std::uint32_t>> nooks(const std::vector<Departure>& asked,
                                                  const std::vector<double>& spacing, const Progress& progress) const;
    // Makes a function the only one on a nook's surfels.
    void set_nook(const std::vector<std::uint32_t>& surfels, std::uint32_t function);
    // That function; no_nook where a surfel is in none as a whole.
    static constexpr std::uint32_t no_nook = 0xffffffffu;
    std::uint32_t nook(std::uint32_t surfel) const { return nook_.empty() ? no_nook : nook_[surfel]; }
    // Is an object one of disks alone, which see all functions around?
    bool is_cloud(std::uint32_t object) const { return is_cloud_[object] != 0; }
    // Do the points of two functions of one level see each other?
    bool joined(std::uint32_t a, std::uint32_t b) const;

private:
    // A lock-free cache of joined(), by function; deterministic, as an answer does not depend on who asks first. Where
    // there is no room for a pair it is asked anew.
    static constexpr std::size_t room = 32;
    struct Pairs {
        std::atomic<std::uint32_t> of[room] = {};  // 2 (other + 1) + answer; 0: free
    };

    void keep_seen(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& weights) const;

    const Scene& scene_;
    const MultilevelBasis& basis_;
    Sight sight_;
    std::size_t most_tries_;                       // functions
    std::vector<char> is_cloud_;                   // objects of disks alone
    std::vector<std::uint32_t> nook_;              // function of each surfel; no_nook, or empty
    std::vector<std::uint32_t> surfel_;            // of functions
    std::vector<Sight::Place> places_;             // of functions
    std::vector<std::unique_ptr<Pairs[]>> pairs_;  // by level
};

}  // namespace surflux
