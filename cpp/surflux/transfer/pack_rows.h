#pragma once

#include <cstdint>
#include <vector>

#include "surflux/transfer/shot_rows.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// Receivers, rows, links and slopes of an operator, as it is applied, from rows as they were shot, in another order:
// row k is that which was shot as order[k].
void pack_rows(ShotRows shot, const std::vector<std::uint32_t>& order, TransportOperator& out);

}  // namespace surflux
