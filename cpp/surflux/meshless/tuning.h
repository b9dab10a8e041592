#pragma once

#include "surflux/solution/tuning.h"

namespace surflux {

// Constants of solve_meshless that trade error against seconds, in one place: no options, for no scene wants others;
// `surflux bench --constants` turns each and shows what it trades.
struct MeshlessTuning {
    // Functions of the coarsest level on all objects together, in proportion to their areas, and on each at least.
    double coarsest_points = 400.0, least_points = 32.0;
    // Cells of the Poisson radius's size that an object's surface may lie in, by that many places on it; else the
    // radius is that much wider, again and again: a wire, or leaves that lie apart, would have points closer to each
    // other than they are far from what is around. A plane has about 1000.
    double most_cells = 1600.0, counted_places = 4096.0, wider_by = 0.25;
    // Longest edges of the cells that darts are thrown on, in Poisson radii, in the first round and the last: then a
    // plane has as many points as after 1000 rejections in a row. Cells as long as the third, or longer, are culled
    // outside the region, and those as long inside geometry.
    double first_edge = 8.0, last_edge = 0.25, culled_edge = 2.0;
    // On a square of a cell's edge: a cell of an eighth of it or more gets one. And on an object in the last round,
    // however small it is.
    double darts_on_square = 8.0, least_darts = 4000.0;
    // Rays beside the one along the normal that must all meet backs where a place is inside geometry, and cosines of
    // the steep half of them and of the flat one.
    double further_rays = 12.0, steep_cosine = 0.5, flat_cosine = 0.17;
    // Points of a level are placed within this many of its Poisson radii of a receiver that is refined: its children,
    // of which the supports reach it, lie within about 2.1, and whose supports reach theirs hold them down to 0 at the
    // rim.
    double placed_reach = 4.4;
    // The heaviest functions that a place looks for an anchor among: where it sees none of these, walls are all around.
    double anchor_tries = 8.0;
    // Supports of finer levels, over the Poisson radius, where few points are around: 2.1 are usual.
    double widest_support = 3.0;
    // Supports of functions for nooks on wide patches: over how far their places reach, and at least this share of the
    // spacing.
    double beyond_nook = 1.25, least_nook = 0.25;
    // A cloud's points are its disks' centres: where receivers are as close as this, in radii of disks, there are no
    // finer ones. What Shepard's weights leave at their own points, about a fifth each time, is corrected by the same
    // ones again, so many times: where all light is close to one place of a cloud, as beside a small ball that glows,
    // it is 7 % off, without 9 to 17 %; elsewhere neither better nor slower.
    double widest_spacing = 3.0;
    double repeats = 2.0;

    // Rays along the surface from a function's point, which find walls that end its support, and ends of one at most.
    double wall_rays = 8.0, most_walls = 2.0;
    // How high above the surface, of their length; cosine above which two walls are one; and of a wall's slope, below
    // which a plane hardly crosses the surface.
    double wall_height = 0.25, same_wall = 0.999, least_wall_slope = 0.3;
    // What the slope of coarser levels adds to the values of one at a place, at most: of their standard deviation
    // around, and of their mean. Of the field anywhere, and of pictures; surfels have means.
    double largest_deviation = 0.5, largest_part = 0.1;

    // Patches are wide whose diameter, over the coarsest spacing, exceeds this; where direct light is in the basis,
    // which changes faster, the second.
    double widest_mean = 1.0, widest_direct_mean = 0.5;
    // Places that tell the mean over a patch at most; and no fewer where it is wide, or partly inside geometry.
    double most_places = 16.0, all_places = 64.0;
    // Of wide patches: in a cell as wide as the spacing of a level, and on all together, shared out by their areas.
    double places_in_cell = 4.0, places_on_wide = 65536.0;

    // A finer level's receiver speaks for less of the surface: from every other level on it has half the rays, down to
    // this many.
    double least_rays = 128.0;
    // A patch on which about this many rays end or more is not sent by its mean: it is nearer than light may change on
    // it.
    double rays_on_a_patch = 4.0;
    // Of the rays of a place, where all that lights shine on are patches: how many sample the hemisphere, and for each
    // of all, how many samples of lit patches. About half of these face the place, and have rays.
    double over_hemisphere = 0.75, light_samples_for_each = 0.5;
    // Lights whose samples would bring this share of the strongest one's, or more, share a sample; those of weaker ones
    // are taken at so many of the points.
    double alike_lights = 0.05, weaker_lights = 0.25;

    // In white rooms light adds up over many bounces until differences are small against it, and errors add up with it:
    // what is allowed goes by the light of one bounce, times this at most.
    double many_bounces = 4.0;
    // Where all else is dark, a lit spot may be off by this share of that, of its own light.
    double own_share = 0.25;
    // In dim parts light may be off by this many times epsilon_e of itself, where it is this share of the RMS or
    // brighter.
    double local_weight = 5.0, dimmest = 1e-3;
    // Standard errors that a difference must be beyond.
    double significance = 1.0;
    // Standard error that a row may have, of what light may be off by in dim parts; and the rays of one that is shot
    // anew for that, at most, over the user's.
    double allowed_noise = 0.5, most_aimed = 4.0;
    // GMRES's tolerance while levels are added, and when energy is balanced: the final one is the user's.
    double rough_tolerance = 3e-2, balanced_tolerance = 1e-3;

    // A surfel with rays of its own has them by the root of its area, all where so many in a row span the spacing of
    // the coarsest level, and this many at least; a patch wider than that by its area, up to so many times as many: it
    // speaks for as many points.
    double own_in_a_row = 16.0, least_own_rays = 64.0, most_for_wide = 16.0;
    // Of the largest surfels that are tried: rays of each; of these, and of the brightest, all together over those of
    // all levels.
    double trying_rays = 16.0, trying_share = 0.0625;
    // Of surfels this much is allowed of what is of points: nothing else is refined with them. And what rays may be off
    // by, of what they bring, times the root of their number: what surfaces send; skies, which are smooth; the few that
    // try.
    double stricter = 0.5, ray_error = 0.6, ray_error_of_skies = 0.04, ray_error_of_few = 1.2;
    // A surfel that has more than this many times the RMS of what is sent is not left to the basis without a look.
    double bright = 4.0;
    ReciprocityTuning reciprocity;
    SelfCheckTuning self_check;

    // Calls visit(name, value) for each.
    template <class Visit>
    void for_each(const Visit& visit) {
        visit("coarsest_points", coarsest_points);
        visit("least_points", least_points);
        visit("widest_support", widest_support);
        visit("beyond_nook", beyond_nook);
        visit("least_nook", least_nook);
        visit("widest_spacing", widest_spacing);
        visit("repeats", repeats);
        visit("wall_rays", wall_rays);
        visit("most_walls", most_walls);
        visit("widest_mean", widest_mean);
        visit("widest_direct_mean", widest_direct_mean);
        visit("most_places", most_places);
        visit("all_places", all_places);
        visit("places_in_cell", places_in_cell);
        visit("places_on_wide", places_on_wide);
        visit("least_rays", least_rays);
        visit("rays_on_a_patch", rays_on_a_patch);
        visit("over_hemisphere", over_hemisphere);
        visit("light_samples_for_each", light_samples_for_each);
        visit("alike_lights", alike_lights);
        visit("weaker_lights", weaker_lights);
        visit("many_bounces", many_bounces);
        visit("own_share", own_share);
        visit("local_weight", local_weight);
        visit("dimmest", dimmest);
        visit("significance", significance);
        visit("allowed_noise", allowed_noise);
        visit("most_aimed", most_aimed);
        visit("rough_tolerance", rough_tolerance);
        visit("balanced_tolerance", balanced_tolerance);
        visit("own_in_a_row", own_in_a_row);
        visit("least_own_rays", least_own_rays);
        visit("most_for_wide", most_for_wide);
        visit("trying_rays", trying_rays);
        visit("trying_share", trying_share);
        visit("stricter", stricter);
        visit("ray_error", ray_error);
        visit("ray_error_of_skies", ray_error_of_skies);
        visit("ray_error_of_few", ray_error_of_few);
        visit("bright", bright);
        visit("most_cells", most_cells);
        visit("counted_places", counted_places);
        visit("wider_by", wider_by);
        visit("first_edge", first_edge);
        visit("last_edge", last_edge);
        visit("culled_edge", culled_edge);
        visit("darts_on_square", darts_on_square);
        visit("least_darts", least_darts);
        visit("further_rays", further_rays);
        visit("steep_cosine", steep_cosine);
        visit("flat_cosine", flat_cosine);
        visit("placed_reach", placed_reach);
        visit("anchor_tries", anchor_tries);
        visit("wall_height", wall_height);
        visit("same_wall", same_wall);
        visit("least_wall_slope", least_wall_slope);
        visit("largest_deviation", largest_deviation);
        visit("largest_part", largest_part);
        reciprocity.for_each(visit);
        self_check.for_each(visit);
    }
};

}  // namespace surflux
