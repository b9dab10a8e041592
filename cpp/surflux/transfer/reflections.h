#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Which leaves exchange light, directly or by way of others: a number of the part that each is in, in the order of the
// leaves. A dim room is solved as well beside a bright one as alone.
std::vector<std::uint32_t> connected_leaves(const TransportOperator& transport);

// What senders send all in all, by node: what is emitted, and so many reflections of it and of the direct irradiance of
// the leaves. `parts`: of connected_leaves(). Each is `channels` interleaved values, `colors` for each of several
// lights, of `reflectance` for all. `bounces` < 0: all there are, by GMRES. Throws ArgumentError, naming `bounces`,
// where these do not add up to anything.
std::vector<float> sent_after(int bounces, const TransportOperator& transport, const std::vector<std::uint32_t>& parts,
                              std::size_t channels, const std::vector<float>& emission,
                              const std::vector<float>& reflectance, const std::vector<float>& direct);

}  // namespace surflux
