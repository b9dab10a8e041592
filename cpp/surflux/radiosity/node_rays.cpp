#include "surflux/radiosity/node_rays.h"

#include <algorithm>
#include <cmath>

#include "surflux/radiosity/lit_points.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

// The error of all is least for given rays where they go by the root of the area.
int NodeRays::usual_rays(std::uint32_t node) const {
    const double share = std::sqrt(tree_.area(node) / usual_area_);
    int rays = rays_;
    for (double least = 0.7; share < least && rays > std::max(16, rays_ / 4); least *= 0.5) rays /= 2;
    return rays;
}

void NodeRays::shoot(Cut& cut, const std::vector<double>* sent, std::size_t channels, const LightParticles& particles,
                     const Progress& progress) {
    Fresh fresh, aimed;
    cut.rays.resize(cut.nodes.size(), 0);
    row_of_.resize(tree_.points(), SurfelTree::none);
    asked_.resize(tree_.points(), 0);
    for (std::size_t k = 0; k < cut.nodes.size(); ++k) {
        const std::uint32_t p = tree_.representative(cut.nodes[k]);
        const int usual = usual_rays(cut.nodes[k]), wanted = sent ? cut.rays[k] : 0;
        const bool aim = wanted >= 2 * usual;
        if (aim ? asked_[p] >= wanted : row_of_[p] != SurfelTree::none) continue;
        asked_[p] = aim ? wanted : usual;
        Fresh& to = aim ? aimed : fresh;
        to.places.push_back(LitPoints::place(tree_, p));
        to.nodes.push_back(cut.nodes[k]);
        to.counts.push_back(aim ? wanted : usual);
    }
    const auto number = [&](const Fresh& of) {
        auto row = static_cast<std::uint32_t>(gathering_.size());
        for (const std::uint32_t node : of.nodes) row_of_[tree_.representative(node)] = row++;
    };
    number(fresh);
    gathering_.add(fresh.places, fresh.counts, progress);
    if (!aimed.nodes.empty()) {
        number(aimed);
        shoot_aimed(aimed, *sent, channels, particles, progress);
        any_aimed_ = true;
    }
    cut.rows.resize(cut.nodes.size());
    last_points_.resize(cut.nodes.size());
    for (std::size_t k = 0; k < cut.nodes.size(); ++k) {
        last_points_[k] = tree_.representative(cut.nodes[k]);
        cut.rows[k] = row_of_[last_points_[k]];
    }
    last_rows_ = cut.rows;
}

void NodeRays::shoot_aimed(const Fresh& fresh, const std::vector<double>& sent, std::size_t channels,
                           const LightParticles& particles, const Progress& progress) {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;
    for (const std::uint32_t p : last_points_) {
        positions.push_back(tree_.position(p));
        normals.push_back(tree_.normal(p));
        objects.push_back(tree_.object(p));
    }
    const auto rows_around = static_cast<std::size_t>(std::lround(tuning_.rows_around));
    const Interpolation sites(positions, normals, objects, standing_at(0, fresh.nodes.size(), progress));
    gathering_.add_aimed(
        fresh.places, fresh.counts,
        [&](std::size_t k, std::vector<Aim>& aims) {
            const Place& place = fresh.places[k];
            std::vector<Interpolation::Weight> near;
            const std::uint32_t object = tree_.object(tree_.representative(fresh.nodes[k]));
            sites.nearest(place.position, place.normal, object, rows_around, near);
            for (const Interpolation::Weight& w : near)
                gathering_.aims_of(last_rows_[w.site], sent, channels, place.position, aims);
            particles.aims_of(fresh.nodes[k], tree_, place.position, aims);
        },
        progress);
}

}  // namespace surflux
