#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/transfer/sparse_rows.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {

// The loops that read most of a local operator, in the widest registers that the processor has. What is added, and
// in which order, is the same in all, and so is what comes of it, bit by bit.

// TransportOperator::gather_tilted of rows `begin` to `end`.
void gather_tilted_rows(const TransportOperator& transport, const float* sent, std::size_t begin, std::size_t end,
                        float* out);

// TransportOperator::gather of as many channels as `colors`, of rows `begin` to `end`.
void gather_color_rows(const TransportOperator& transport, const float* sent, std::size_t begin, std::size_t end,
                       float* out);

// Irradiance at surfels with such normals, `at_surfels` being TransportOperator::at_surfels: of `begin` to `end`, from
// coefficients with gradients, `tilted_channels` of each function.
void irradiance_at_rows(const SparseRows& at_surfels, const std::vector<Vec3>& normals, const float* coefficients,
                        std::size_t begin, std::size_t end, Rgb* out);

}  // namespace surflux
