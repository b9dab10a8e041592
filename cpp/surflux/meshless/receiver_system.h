#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/meshless_exchange.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/meshless/oracle.h"
#include "surflux/meshless/receivers.h"
#include "surflux/solution/linear.h"
#include "surflux/solution/reciprocal_scaling.h"

namespace surflux {

// The linear system of irradiance at receivers, x = c + T x (L07 eq. 14): c needs no solving, T is one bounce of the
// functions whose coefficients x is projected to, by the rows of a HemisphereGather.
class ReceiverSystem {
public:
    // bounces: how many are added up; fewer than 0: all, by GMRES.
    ReceiverSystem(const Receivers& receivers, HemisphereGather& gather, int bounces)
        : receivers_(receivers), gather_(gather), bounces_(bounces) {}

    // Takes the gather's next rows, `direct` being what lights bring to each; empty where that is beside the basis.
    void add(std::size_t rows, const std::vector<Rgb>& direct);

    // Rows anew, by rays that are aimed (HemisphereGather::aim).
    void aim(const std::vector<HemisphereGather::Shot>& rows, const HemisphereGather::Aims& aims,
             const Progress& progress);

    // From the values of before; the field has the coefficients of the result, and of its direct light.
    LinearReport solve(double tolerance, MeshlessField& field, const Progress& progress);

    // Factors by reciprocity, of rows and senders, for about the light of the field (MeshlessExchange).
    ReciprocalScaling scale_by_reciprocity(const MeshlessExchange& exchange, const MeshlessField& field,
                                           const ReciprocityTuning& tuning, const Progress& progress);
    // With these, the factors that keep the power of senders (MeshlessExchange::sender_power): emission and the first
    // bounce are scaled by them, and what they change in one bounce of the field as it is joins c as a constant, so
    // that T stays.
    void keep_power(const MeshlessExchange& exchange, const ReciprocalScaling& scaling, const MeshlessField& field);

    const Received& rows() const { return rows_; }
    // Values before their last bounce, which surfaces send.
    const std::vector<Rgb>& before() const { return before_; }
    // What each surfel sends of the field as the last solve() has left it, of light in the basis.
    const std::vector<Rgb>& sent() const { return sent_; }

private:
    template <class Set>
    void set_factors(const Set& set);
    std::vector<Rgb> bounce(const std::vector<Rgb>& x, MeshlessField& field);

    const Receivers& receivers_;
    HemisphereGather& gather_;
    const int bounces_;
    Received rows_;
    std::vector<Rgb> before_;
    std::vector<Rgb> correction_;       // of what each row gathers, that keeps its power; empty: none
    std::vector<std::uint32_t> parts_;  // connected part of each row; empty: one
    std::vector<Rgb> sent_;             // of each surfel
};

}  // namespace surflux
