#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Which leaves exchange light, directly or by way of others: a dim room is solved as well beside a bright one as alone.
class ConnectedLeaves {
public:
    // A number of the part that each leaf is in, in their order: found when it is first asked for.
    const std::vector<std::uint32_t>& of(const TransportOperator& transport) const;

private:
    mutable std::once_flag once_;
    mutable std::vector<std::uint32_t> parts_;
};

// What senders send all in all, by node: what is emitted, and so many reflections of it and of the direct irradiance of
// the leaves. `connected`: of this operator. Each is `channels` interleaved values, `colors` for each of several
// lights, of `reflectance` for all. `bounces` < 0: all there are, by GMRES. Throws ArgumentError, naming `bounces`,
// where these do not add up to anything.
std::vector<float> sent_after(int bounces, const TransportOperator& transport, const ConnectedLeaves& connected,
                              std::size_t channels, const std::vector<float>& emission,
                              const std::vector<float>& reflectance, const std::vector<float>& direct);

}  // namespace surflux
