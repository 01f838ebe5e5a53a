// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "polygonization/evidence_grid.h"
#include "polygonization/outline_tracer.h"

namespace terrace {

/// The way back from an outline to evidence: cells whose middle lies in the piece were seen, those whose
/// middle lies in a hole were seen through.
/// @param strength  of the evidence where it was seen, at least EvidenceGrid::kOn
void TakeForSeen(const TracedPiece& piece, std::int8_t strength, EvidenceGrid* evidence);

}  // namespace terrace
