#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surflux {

// Constants of what solvers share that trade error against seconds: each solver has those of the parts that it takes
// among its own; `surflux bench --constants` turns them there, one solver at a time.

// Of NodalField.
struct NodalTuning {
    // Nodes that a slope is fitted to, itself among them: more take longer and carry slopes over what bends.
    double slope_neighbors = 9.0;
    // What another normal may make of a value, at least and at most: nearer to 1 less overshoots, and less turns.
    double least_turn = 0.3, most_turn = 3.0;
    // What slopes and turns may make of a value by weights alone, or its inverse.
    double most_sloped = 2.0;
    // Overshoot that slopes may make, over the range of values around; and of the least value around that below which
    // they do not fall.
    double spare_share = 0.25, least_share = 0.25;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        for_each_of_slopes(visit);
        visit("least_turn", least_turn);
        visit("most_turn", most_turn);
        visit("most_sloped", most_sloped);
    }
    // For those of fields that do not say how they turn, asked at single places.
    template <class Visit>
    void for_each_of_slopes(const Visit& visit) {
        visit("slope_neighbors", slope_neighbors);
        visit("spare_share", spare_share);
        visit("least_share", least_share);
    }
};

// Of without_noise(): more nodes take more noise off, and blur more.
struct RegressionTuning {
    // Nodes that a fit needs, for six terms some more than six; nodes whose errors tell the variance of one, and whose
    // risks tell that of one.
    double least_nodes = 9.0, pooled_nodes = 9.0, averaged_nodes = 12.0;
    // Cosine between normals above which nodes are of one surface.
    double like_normals = 0.95;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("least_nodes", least_nodes);
        visit("pooled_nodes", pooled_nodes);
        visit("averaged_nodes", averaged_nodes);
        visit("like_normals", like_normals);
    }
};

// Of scale_by_reciprocity(): what keeps energy, and how near to where it was lost.
struct ReciprocityTuning {
    // Rays that met a group of senders: fewer mend nearer, with factors that have a standard error of more than 6 %.
    double rays_of_group = 256.0;
    // What a difference of normals counts beside one of places where senders are grouped.
    double normal_weight = 0.5;
    // What is left after a round, over what was, above which it is the last of its part.
    double least_progress = 0.95;
    // Standard deviations of radiosity within a group beyond which rays tell too little of a sender.
    double largest_score = 2.0;
    // Factor of senders beside others of their group, and of the power of a group. Where more than this is wanted, rows
    // have too little of what is sent for any factor to mend, such as in cracks where none are: it stays off.
    double largest_factor = 2.0;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("rays_of_group", rays_of_group);
        visit("normal_weight", normal_weight);
        visit("least_progress", least_progress);
        visit("largest_score", largest_score);
        visit("largest_factor", largest_factor);
    }
};

// Of the self-check. They leave the solution as it is, and trade how well its error is known against seconds.
struct SelfCheckTuning {
    // Surfels that are checked; of these in a region, of the coarse system that errors go around in.
    double checked_surfels = 2000.0, checks_per_region = 32.0;
    // Rays over the hemisphere, of each half of each surfel, that it begins with.
    double check_rays = 64.0;
    // Relative standard error of the error at which no more rays are traced; and of what rays can tell over the error
    // by local light.
    double known_error = 0.125, known_local_error = 0.5;
    // Rays that may be traced, whatever it is: so many, or that share of the rays of the solution itself.
    double least_check_rays = 1048576.0, most_check_share = 0.25;
    // Times the mean square of H, or a part of it, that surfels drawn by area may have: beyond that half of them are
    // drawn by what each has of it.
    double most_off = 2.0;
    // What is dimmer than this, over the mean light of a region, is a region of its own, where it is that share of the
    // area, and the rest as well.
    double dim_region = 0.25, least_dim_part = 0.125;
    // Widths of a surfel within which the light across it is not taken as one value.
    double near_widths = 2.0;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("checked_surfels", checked_surfels);
        visit("checks_per_region", checks_per_region);
        visit("check_rays", check_rays);
        visit("known_error", known_error);
        visit("known_local_error", known_local_error);
        visit("least_check_rays", least_check_rays);
        visit("most_check_share", most_check_share);
        visit("most_off", most_off);
        visit("dim_region", dim_region);
        visit("least_dim_part", least_dim_part);
        visit("near_widths", near_widths);
    }
};

// A constant that stands for a number of things, one at least.
inline std::size_t whole_number(double value) { return static_cast<std::size_t>(std::max(1L, std::lround(value))); }

}  // namespace surflux
