#pragma once

#include <vector>

#include "surflux/core/vec.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// What senders send all in all, three channels by node: what is emitted, and so many reflections of it and of the
// direct irradiance of the leaves. `bounces` < 0: until what another would bring is no thousandth.
std::vector<float> sent_after(int bounces, const TransportOperator& transport, const std::vector<float>& emission,
                              const std::vector<float>& reflectance, const std::vector<float>& direct);

}  // namespace surflux
