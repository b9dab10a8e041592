#pragma once

namespace surflux {

// Constants of global refinement that trade error against seconds, in one place: no options, for no scene wants others;
// `surflux bench --constants` turns each and shows what it trades.
struct RefinementTuning {
    // The cut that refinement begins with: more nodes at once are fewer iterations, and rays where none were needed.
    double surfels_per_first_node = 500.0;
    // A node is refined where what is close by differs: closeness times deviation of what rays bring, weighed by this.
    double closeness_weight = 1.5;
    // Rays from each of some surfels below a group, which tell what nodes around do not know of it, and what share of
    // what they find is taken to be chance at least: more rays see smaller things, less chance refines more.
    double probe_rays = 32.0;
    double probe_error = 0.08;
    // Areas of nodes beside each other, above which the larger is refined: interpolation between unlike nodes is poor.
    double most_unlike = 32.0;
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
    }
};

}  // namespace surflux
