// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/edge_evidence.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// A square of one metre that was seen, and evidence around it as far as it is taken there.
class EdgeEvidenceTest : public testing::Test {
 protected:
  EdgeEvidenceTest() {
    piece_.outline = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    Know(0.0, 1.0, 0.0, 1.0, 10);
  }
  void Know(double low_x, double high_x, double low_y, double high_y, std::int8_t known) {
    for (int y = evidence_.CellIndex(low_y + 0.005); y < evidence_.CellIndex(high_y + 0.005); ++y)
      evidence_.Fill(y, evidence_.CellIndex(low_x + 0.005), evidence_.CellIndex(high_x + 0.005), known);
  }

  TracedPiece piece_;
  EvidenceGrid evidence_{0.01};
};

TEST_F(EdgeEvidenceTest, NothingIsSeenPastEdgesBeyondWhichNothingWasLookedAt) {
  EXPECT_EQ(EdgesSeenPast(piece_, evidence_), std::vector<bool>(4, false));
}

TEST_F(EdgeEvidenceTest, OneLooksPastTheEdgeBeyondWhichPixelsSawFartherOrNothing) {
  Know(1.0, 1.02, 0.0, 0.5, EvidenceGrid::kThrough);
  Know(1.0, 1.02, 0.5, 1.0, -1);
  EXPECT_EQ(EdgesSeenPast(piece_, evidence_), (std::vector<bool>{false, true, false, false}));
}

TEST_F(EdgeEvidenceTest, NoOneLooksPastAnEdgeWhereTheSurfaceWasCutAndGoesOn) {
  Know(1.0, 1.1, 0.0, 1.0, 5);
  Know(1.0, 1.1, 0.45, 0.55, EvidenceGrid::kThrough);
  EXPECT_EQ(EdgesSeenPast(piece_, evidence_), std::vector<bool>(4, false));
}

TEST_F(EdgeEvidenceTest, AShortEdgeIsSeenPastWithThoseBesideIt) {
  piece_.outline = {{0, 0}, {1, 0}, {1, 0.5}, {1, 0.51}, {1, 1}, {0, 1}};
  Know(1.0, 1.02, 0.0, 1.0, EvidenceGrid::kThrough);
  EXPECT_EQ(EdgesSeenPast(piece_, evidence_), (std::vector<bool>{false, true, true, true, false, false}));
}

TEST_F(EdgeEvidenceTest, HolesComeAfterTheOutline) {
  piece_.holes = {{{0.4, 0.4}, {0.4, 0.6}, {0.6, 0.6}, {0.6, 0.4}}};
  Know(0.4, 0.6, 0.4, 0.6, EvidenceGrid::kThrough);
  EXPECT_EQ(EdgesSeenPast(piece_, evidence_),
            (std::vector<bool>{false, false, false, false, true, true, true, true}));
}

}  // namespace
}  // namespace terrace
