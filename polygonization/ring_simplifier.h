// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "polygonization/plane_rings.h"

namespace terrace {

/// The rings of one traced piece with fewer vertices: edges are lines fitted to what they replace and leave
/// it by no more than the tolerance. They neither cross nor touch; the traced ones must not either.
/// @param max_vertices  of all rings together; ragged ones are simplified further, as far as they allow
std::vector<Ring2> SimplifyRings(const std::vector<Ring2>& traced, double tolerance_m, int max_vertices);

}  // namespace terrace
