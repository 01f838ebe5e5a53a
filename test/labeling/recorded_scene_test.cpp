// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "datasets/ground_truth.h"
#include "label_scene.h"

namespace terrace {
namespace {

/// The rectangle of a true polygon that the recording saw; empty when it saw none of it.
Ring SeenPart(const TruePolygon& polygon) {
  const ObservedCells& cells = polygon.observed;
  Eigen::Vector2i low = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i high = Eigen::Vector2i::Constant(-1);
  for (int i = 0; i < cells.nx; ++i) {
    for (int j = 0; j < cells.ny; ++j) {
      if (!cells.seen[static_cast<std::size_t>(i) * cells.ny + j]) continue;
      low = low.cwiseMin(Eigen::Vector2i(i, j));
      high = high.cwiseMax(Eigen::Vector2i(i, j));
    }
  }
  if (high.x() < 0) return {};
  const auto at = [&](int i, int j) {
    return Eigen::Vector3d(cells.axis_x * (cells.origin_m.x() + cells.cell_m * i) +
                           cells.axis_y * (cells.origin_m.y() + cells.cell_m * j) +
                           polygon.plane_world.normal * polygon.plane_world.offset_m);
  };
  Ring ring{at(low.x(), low.y()), at(high.x() + 1, low.y()), at(high.x() + 1, high.y() + 1),
            at(low.x(), high.y() + 1)};
  if (SignedArea(ring, polygon.plane_world.normal) < 0.0) std::reverse(ring.begin(), ring.end());
  return ring;
}

TEST(RecordedSceneTest, TruePlanesAsFarAsTheyWereSeenGetTheirTrueLabels) {
  const char* data = std::getenv("TERRACE_DATA");
  if (!data) GTEST_SKIP() << "TERRACE_DATA is not set: the recorded scene is not looked for.";
  const TrueScene truth = LoadTrueScene(std::filesystem::path(data) / "corridor_stairs");
  LabelScene scene;
  for (const TruePolygon& polygon : truth.polygons) {
    const auto label = TerrainLabelFromName(polygon.label);
    const Ring ring = SeenPart(polygon);
    if (polygon.detail || !label || ring.empty()) continue;
    scene.Add({ring, {}, *label, polygon.step_index.value_or(0)});
  }
  ASSERT_GT(scene.pieces.size(), 20u);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    TerrainLabeler labeler = MakeLabeler();
    const PolygonUpdate update = scene.Update({0.004, 0.015, 0.015}, seed);
    LabelOften(labeler, update, StandingAt(2.1, 0));
    const TerrainMapPtr map = LabelOften(labeler, update, StandingAt(6.0, 0));
    EXPECT_EQ(WrongLabels(scene, *map), "") << "seed " << seed;
    ASSERT_EQ(map->staircases.size(), 1u) << "seed " << seed;
    const Staircase& s = map->staircases[0];
    EXPECT_EQ(s.num_risers, truth.staircases[0].num_risers);
    EXPECT_EQ(s.num_treads, truth.staircases[0].num_treads);
    EXPECT_NEAR(s.riser_m, truth.staircases[0].riser_m, 0.005);
    EXPECT_NEAR(s.tread_m, truth.staircases[0].tread_m, 0.01);
    EXPECT_NEAR(s.width_m, truth.staircases[0].width_m, 0.08);
  }
}

}  // namespace
}  // namespace terrace
