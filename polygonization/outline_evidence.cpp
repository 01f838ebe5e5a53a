// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace terrace {
namespace {

/// Fills the cells inside rings, row by row: between every other pair of edges that a row crosses.
void FillInside(const std::vector<const Ring2*>& rings, std::int8_t known, EvidenceGrid* evidence) {
  Eigen::AlignedBox2d box;
  for (const Ring2* ring : rings)
    for (const Eigen::Vector2d& p : *ring) box.extend(p);
  if (box.isEmpty()) return;
  const double cell_m = evidence->cell_m();
  std::vector<double> crossings;
  for (int y = evidence->CellIndex(box.min().y()); y <= evidence->CellIndex(box.max().y()); ++y) {
    const double row_m = cell_m * (y + 0.5);
    crossings.clear();
    for (const Ring2* ring : rings) {
      for (std::size_t i = 0; i < ring->size(); ++i) {
        const Eigen::Vector2d &a = (*ring)[i], &b = (*ring)[(i + 1) % ring->size()];
        if ((a.y() > row_m) == (b.y() > row_m)) continue;
        crossings.push_back(a.x() + (row_m - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
      }
    }
    std::sort(crossings.begin(), crossings.end());
    // The first cell whose middle does not lie before a crossing.
    const auto cell_from = [&](double x) { return static_cast<int>(std::ceil(x / cell_m - 0.5)); };
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
      evidence->Fill(y, cell_from(crossings[i]), cell_from(crossings[i + 1]), known);
  }
}

}  // namespace

void TakeForSeen(const TracedPiece& piece, std::int8_t strength, EvidenceGrid* evidence) {
  std::vector<const Ring2*> rings{&piece.outline};
  for (const Ring2& hole : piece.holes) {
    rings.push_back(&hole);
    FillInside({&hole}, EvidenceGrid::kThrough, evidence);
  }
  FillInside(rings, strength, evidence);
}

}  // namespace terrace
