#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/gathering.h"
#include "surflux/radiosity/light_particles.h"
#include "surflux/radiosity/tuning.h"

namespace surflux {

// The rows of a Gathering that nodes of a cut have: each is shot once, from the surfel that stands for the node, and
// kept while the cut changes, also for surfels that stand for a group and then for themselves. Nodes that want more
// rays (Cut::rays) get a new row, aimed at what rows around it know to be bright (lights/aimed_row.h).
class NodeRays {
public:
    // `rays`: of a node of `usual_area` or more; smaller ones have fewer.
    NodeRays(const SurfelTree& tree, Gathering& gathering, int rays, double usual_area, const RefinementTuning& tuning)
        : tree_(tree), gathering_(gathering), rays_(rays), usual_area_(usual_area), tuning_(tuning) {}

    // Shoots what is missing, and fills in the rows of the cut. `sent`: what all nodes sent last, `channels`
    // interleaved; none are aimed before there is any.
    void shoot(Cut& cut, const std::vector<double>* sent, std::size_t channels, const LightParticles& particles,
               const Progress& progress);
    // Are any aimed?
    bool any_aimed() const { return any_aimed_; }
    // Nothing more is shot: gives back what that alone needs.
    void end() {
        std::vector<std::uint32_t>().swap(row_of_);
        std::vector<int>().swap(asked_);
    }

private:
    struct Fresh {
        std::vector<Place> places;
        std::vector<std::uint32_t> nodes;
        std::vector<int> counts;
    };
    int usual_rays(std::uint32_t node) const;
    void shoot_aimed(const Fresh& fresh, const std::vector<double>& sent, std::size_t channels,
                     const LightParticles& particles, const Progress& progress);

    const SurfelTree& tree_;
    Gathering& gathering_;
    int rays_;
    double usual_area_;
    RefinementTuning tuning_;
    bool any_aimed_ = false;
    std::vector<std::uint32_t> row_of_;                   // of points that stand for a node
    std::vector<int> asked_;                              // rays that their last rows were to have: aimed ones round
    std::vector<std::uint32_t> last_rows_, last_points_;  // of the cut that was solved last
};

}  // namespace surflux
