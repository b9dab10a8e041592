#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// What senders send all in all, by node: what is emitted, and so many reflections of it and of the direct irradiance of
// the leaves. Each is `channels` interleaved values, `colors` for each of several lights, of `reflectance` for all.
// `bounces` < 0: all there are, by GMRES. Throws ArgumentError, naming `bounces`, where these do not add up to
// anything.
std::vector<float> sent_after(int bounces, const TransportOperator& transport, std::size_t channels,
                              const std::vector<float>& emission, const std::vector<float>& reflectance,
                              const std::vector<float>& direct);

}  // namespace surflux
