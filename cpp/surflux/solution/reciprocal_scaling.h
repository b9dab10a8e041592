#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/bisection.h"
#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/solution/tuning.h"

namespace surflux {

// Shares of a place's cosine-weighted hemisphere that meet no fronts, estimated by rays, with their variance.
struct HemisphereLoss {
    double escape = 0.0, into_backs = 0.0;
    double bias = 0.0;      // what met() may be off by as it is interpolated
    double variance = 0.0;  // by the rays of the nodes it is interpolated from, times the area that varies as one
    double met() const { return std::max(0.0, 1.0 - escape - into_backs); }
};

// Binomial variance p (1 - p) / n of a share that n rays found; where none did, as if one had.
inline double variance_of_share(double met, double rays) {
    return std::max(met, 1.0 / rays) * std::max(0.0, 1.0 - met) / rays;
}

// A transport matrix G estimated row by row by rays: G[k, j] is the share of receiver k's hemisphere that sender j
// fills. Rows conserve energy by construction: with what escapes and what backs absorb they make 1. Columns do not: by
// reciprocity, what all receive from a sender is what its own rays say meets fronts, but rays have variance, and
// interpolation has bias at edges.
struct RayExchange {
    // out[k] = sum_j G[k, j] sent[j]; out[j] = sum_k G[k, j] weight[k].
    std::function<void(const std::vector<double>& sent, std::vector<double>& out)> gather, scatter;
    std::vector<double> area;  // that each row stands for: the integral of its weights
    std::vector<double> met;   // share of each row's hemisphere that meets fronts
    std::vector<std::uint32_t> rays;
    std::vector<double> bias;  // what interpolating `met` around each row may be off by
    // In floats, so in units of the scene: areas of its own, `area` too, and radiosity of the brightest.
    struct Sender {
        float radiosity;  // about what it sends
        float carried;    // of that, what goes by these rows: its power is kept
        float area;
        float met, bias, variance;  // as in HemisphereLoss
        std::uint32_t part;         // connected part of the scene
    };
    std::vector<Sender> sender;
    using Place = PlaceAndNormal;
    std::function<Place(std::size_t sender)> place;
};

struct ReciprocalScaling {
    // Where a larger factor is wanted, columns stay off, and `after` has it.
    double largest_factor = ReciprocityTuning{}.largest_factor;
    double bounded(double factor) const { return std::clamp(factor, 1.0 / largest_factor, largest_factor); }

    std::vector<double> rows, senders;
    std::vector<std::uint32_t> group;  // of each sender
    std::size_t groups = 0;
    std::vector<double> lost;  // of each group: what its senders' own rays say they lose is to be multiplied by
    // Of each group: relative variances of the power that it sends, by what senders' own rays say, and that all receive
    // of it.
    struct Variances {
        double sent, received;
        // Weight of the former by inverse variances, where its radiosity has a relative variance, too.
        double sender_weight(double of_radiosity = 0.0) const {
            const double all = sent + of_radiosity + received;
            return all > 0.0 && std::isfinite(all) ? received / all : 0.0;
        }
    };
    std::vector<Variances> variances;
    // Sum over groups of |received - sent|, over all that is sent: of everything, and of the part that is worst.
    double before = 0.0, after = 0.0;
};

// Factors r and s with which r G s has the rows it had and, group by group of senders, columns by reciprocity (Sinkhorn
// and Knopp 1967): sum_k area[k] r[k] G[k, j] s[j] = area[j] met[j], of the area and of the power that a group sends,
// for which s rises evenly with the radiosity within it, as far as rays tell of it. A group is as small as some hundred
// rays that met it allow: neighbours in one connected part that face about the same way. So what is mended stays where
// it was lost, and no factor knows of another part of the scene. Of both sides of that equation the one that is known
// better counts for more, by their variances: in a closed room `met` is 1 everywhere, without variance; where a ball
// rests on a wide floor under the sky, the floor's few rays that meet it say less than those of the ball, and what
// leaves the floor for the sky is what the ball does not receive (`lost`).
//   Rows are scaled last, with what they lose: r (G s + escape + into backs) = 1. So a row of which few rays met fronts
// may meet more, as its senders have it; surfaces reflect less than 1, so the spectral radius is below 1, and a closed
// uniform furnace is exact.
ReciprocalScaling scale_by_reciprocity(const RayExchange& exchange, const Progress& progress = {},
                                       const ReciprocityTuning& tuning = {});

}  // namespace surflux
