#pragma once

#include "surflux/solution/tuning.h"

namespace surflux {

// Constants of the exchange of all pairs that trade error against seconds, in one place: no options, for no scene wants
// others; `surflux bench --constants` turns each and shows what it trades.
struct PairsTuning {
    // Distances, over the larger surfel's extent, up to which the form factor of a pair is integrated over one of the
    // two in closed form; up to which it is a small quadrature over both; and the latter where both are patches.
    double mid_ratio = 3.5, far_ratio = 10.0, patches_far_ratio = 40.0;
    // Shadow rays of a pair that is near, some diameters apart (of disks always one), and far; of one that exchanges
    // much, so many times its form factor, up to as many; of one that a lamp is in; and so many times as many where
    // patches see each other in part.
    double near_rays = 16.0, mid_rays = 4.0, far_rays = 1.0;
    double rays_per_factor = 256.0, most_rays = 64.0;
    double lamp_rays = 16.0;
    double more_rays = 8.0;
    // Form factor above which a near pair's rays leave the smaller surfel as its light does, so many over its
    // hemisphere: in contact, points spread over both would miss where light passes.
    double large_factor = 0.1;
    double hemisphere_rays = 128.0;
    // How far the losses of disks follow their scale when rows are closed, and how far all else follows that of near
    // pairs. Measured on a ball and in corners under lights and skies: from 0.1 to 0.3 all the same, and the error up
    // to 2 times less than at 1.
    double yield_of_disks = 0.1, yield_of_rest = 0.1;
    // Scale of a row at most: what it lacks beyond that counts as absorbed.
    double largest_scale = 2.0;
    // When surfels are inserted afterwards: those around one, itself among them, whose differences tell the noise of
    // its emitters' light; and what part of these interpolation is off by, of second order half as far on.
    double surfels_around = 9.0, between_places = 0.25;
    NodalTuning nodal;  // of what is interpolated to them
    SelfCheckTuning self_check;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("mid_ratio", mid_ratio);
        visit("far_ratio", far_ratio);
        visit("patches_far_ratio", patches_far_ratio);
        visit("near_rays", near_rays);
        visit("mid_rays", mid_rays);
        visit("far_rays", far_rays);
        visit("rays_per_factor", rays_per_factor);
        visit("most_rays", most_rays);
        visit("lamp_rays", lamp_rays);
        visit("more_rays", more_rays);
        visit("large_factor", large_factor);
        visit("hemisphere_rays", hemisphere_rays);
        visit("yield_of_disks", yield_of_disks);
        visit("yield_of_rest", yield_of_rest);
        visit("largest_scale", largest_scale);
        visit("surfels_around", surfels_around);
        visit("between_places", between_places);
        nodal.for_each_of_slopes(visit);
        self_check.for_each(visit);
    }
};

// Constants of form_factors() that trade error against seconds, likewise: how the free share of a pair is sampled.
struct FormFactorTuning {
    // Points of each of eight streams that are tried first, and at most; the latter of disks.
    double first_points = 4.0, most_points = 131072.0, most_points_of_disks = 64.0;
    // Form factor above which rays of near pairs leave the smaller surfel as its light does: the kernel of patches that
    // touch has no variance to sample by.
    double hemisphere_factor = 0.003;
    // What shares of disks may be off by, whatever is asked for: their exchange is known to some per cent close by.
    double disk_error = 0.05;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("first_points", first_points);
        visit("most_points", most_points);
        visit("most_points_of_disks", most_points_of_disks);
        visit("hemisphere_factor", hemisphere_factor);
        visit("disk_error", disk_error);
    }
};

// Constants of global refinement that trade error against seconds, in one place: no options, for no scene wants others;
// `surflux bench --constants` turns each and shows what it trades.
struct RefinementTuning {
    // The cut that refinement begins with: more nodes at once are fewer iterations, and rays where none were needed.
    double surfels_per_first_node = 500.0, least_first_nodes = 200.0;
    // What a level of the hierarchy has fewer than the one below, at least: less steep ones are memory for little.
    double least_shrinking = 0.05;
    // Tests of the cut, at most, and rounds of more rays once it is as it will be.
    double most_iterations = 16.0, most_sharpenings = 2.0;
    // A node is refined where what is close by differs: closeness times deviation of what rays bring, weighed by this.
    double closeness_weight = 1.5;
    // Rays from each of some surfels below a group, which tell what nodes around do not know of it, and what share of
    // what they find is taken to be chance at least: more rays see smaller things, less chance refines more.
    double probe_rays = 32.0;
    double probe_error = 0.08;
    // Areas of nodes beside each other, above which the larger is refined: interpolation between unlike nodes is poor.
    double most_unlike = 32.0;
    // So many around it, itself among them, are asked about a node; of these so many must be that much smaller, for one
    // alone may be what was left over when groups were grown.
    double nodes_around = 9.0, fewest_finer = 2.0;
    // Share of the mean area of surfels, by area, up to which a node gets all rays; larger ones get fewer.
    double usual_share = 0.25;
    // GMRES's tolerance while nodes are refined, and when energy is balanced: the final one is the user's.
    double rough_tolerance = 3e-2;
    double balanced_tolerance = 1e-3;
    // Share of the surface that is not worth another iteration.
    double little = 1e-3;
    // Cosine below which cones of rays are taken to be no wider: their groups would span walls.
    double grazing = 0.25;
    // Standard errors by which a difference must exceed the noise of rays to count.
    double significance = 2.0;
    // An eye goes by the light around it: what may be left is zeta times the RMS of H, and no more than zeta times this
    // many times what light there is (local_light.h), which counts as this share of the RMS at least.
    double local_weight = 10.0;
    double dimmest = 1e-3;
    // Where the standard error of a node's rays is more than that, it gets more of them, up to so many times.
    double most_more_rays = 4.0;
    // Share of the light that particles bring to a node, of which its rays must have met as much at least; and of the
    // RMS of H, below which places are so dim that particles are asked. What has no light is below any.
    double missed = 0.25;
    double dim = 0.01;
    // Radius of the smallest surfel that is inserted, over that of the scene's (RMS by area): finer borders of shadows.
    double smallest_share = 0.0625;
    // Where children of an inserted surfel stand before they repel each other, over its radius (c of D04 7.2); how
    // often they move, from how many leaves around them, by which part of what those want; and how far they get, over
    // its radius.
    double spread_of_children = 0.3, repulsion_rounds = 5.0, repelling = 12.0, repulsion_step = 0.3;
    double farthest_child = 0.75;
    // Rows around one that has too much noise, by whose light its further rays are aimed.
    double rows_around = 9.0;
    // Nodes around one whose rays are aimed, from which on its own are: it knows less than they do.
    double fewest_aimed = 6.0;
    // Times the rays that a node has, which it may get at once: then it is asked again.
    double most_at_once = 4.0;
    // Surfels of a group that are drawn and looked at for those at its corners, which are probed.
    double drawn_leaves = 64.0, corners = 4.0;
    // Particles for each surfel, from all that sends, which tell what lights places too dim for rays; and how many of
    // those that arrive at a node its rays are aimed at, at most.
    double particles_of_surfel = 32.0, most_aims = 64.0;
    // So many at least and at most; and how many must arrive at a node to tell: fewer are chance.
    double least_particles = 65536.0, most_particles = 1048576.0, telling_particles = 3.0;
    // 1 / cos of rays, of which slopes are made, at most: their mean square does not exist.
    double steepest = 8.0;
    // Nearest disks that are kept of each, of so many that are looked at, to tell which of overlapping ones a ray
    // means; and squared distance from a centre, over the area, within which it is that one's: .4 of the spacing.
    double disks_beside = 8.0, disks_looked_at = 24.0, own_cell = 0.16;
    // Leaves that tell a slope, the one itself among them; and rounds in which sources are refined.
    double leaves_around = 9.0, insertion_rounds = 6.0;
    // Points that normals between them go by, the point itself among them; how stiff their slopes are; and cosine of
    // what they may turn by: beyond that they are not of one smooth surface.
    double normals_around = 9.0, normal_stiffness = 0.01, most_normal_turn = 0.5;
    NodalTuning nodal;
    RegressionTuning regression;
    ReciprocityTuning reciprocity;
    SelfCheckTuning self_check;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("surfels_per_first_node", surfels_per_first_node);
        visit("closeness_weight", closeness_weight);
        visit("probe_rays", probe_rays);
        visit("probe_error", probe_error);
        visit("most_unlike", most_unlike);
        visit("usual_share", usual_share);
        visit("rough_tolerance", rough_tolerance);
        visit("balanced_tolerance", balanced_tolerance);
        visit("little", little);
        visit("grazing", grazing);
        visit("significance", significance);
        visit("local_weight", local_weight);
        visit("dimmest", dimmest);
        visit("most_more_rays", most_more_rays);
        visit("missed", missed);
        visit("dim", dim);
        visit("smallest_share", smallest_share);
        visit("spread_of_children", spread_of_children);
        visit("repulsion_rounds", repulsion_rounds);
        visit("repelling", repelling);
        visit("repulsion_step", repulsion_step);
        visit("farthest_child", farthest_child);
        visit("rows_around", rows_around);
        visit("most_at_once", most_at_once);
        visit("drawn_leaves", drawn_leaves);
        visit("particles_of_surfel", particles_of_surfel);
        visit("most_aims", most_aims);
        visit("least_first_nodes", least_first_nodes);
        visit("least_shrinking", least_shrinking);
        visit("most_iterations", most_iterations);
        visit("most_sharpenings", most_sharpenings);
        visit("nodes_around", nodes_around);
        visit("fewest_finer", fewest_finer);
        visit("corners", corners);
        visit("fewest_aimed", fewest_aimed);
        visit("least_particles", least_particles);
        visit("most_particles", most_particles);
        visit("telling_particles", telling_particles);
        visit("steepest", steepest);
        visit("disks_beside", disks_beside);
        visit("disks_looked_at", disks_looked_at);
        visit("own_cell", own_cell);
        visit("leaves_around", leaves_around);
        visit("insertion_rounds", insertion_rounds);
        visit("normals_around", normals_around);
        visit("normal_stiffness", normal_stiffness);
        visit("most_normal_turn", most_normal_turn);
        nodal.for_each(visit);
        regression.for_each(visit);
        reciprocity.for_each(visit);
        self_check.for_each(visit);
    }
};

}  // namespace surflux
