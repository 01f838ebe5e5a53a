// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "polygonization/evidence_grid.h"
#include "polygonization/outline_tracer.h"

namespace terrace {

/// Beyond which edges of a piece one looks past its plane: pixels there saw something farther away, or were
/// in view and saw nothing. Elsewhere nothing was looked at, or something else is in the way.
/// @return one for each edge: of the outline first, then of the holes
std::vector<bool> EdgesSeenPast(const TracedPiece& piece, const EvidenceGrid& evidence);

}  // namespace terrace
