// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/predicted_regions.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

/// A flight of six risers on a floor; of the treads the first `num_treads`, of the faces all.
LabelScene FacesAndTreads(int num_treads) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 2);
  KnownFlight flight;
  flight.foot = {3, 0, 0};
  scene.AddFlight(flight);
  std::erase_if(scene.pieces, [&](const KnownPiece& piece) {
    return piece.label == TerrainLabel::kStairTread && piece.step_index > num_treads;
  });
  return scene;
}

std::vector<std::shared_ptr<const TerrainRegion>> PredictedIn(const TerrainMap& map) {
  std::vector<std::shared_ptr<const TerrainRegion>> predicted;
  for (const auto& region : map.regions)
    if (region->predicted()) predicted.push_back(region);
  return predicted;
}

TEST(PredictedRegionsTest, AreRegionsOfTheStaircaseThatSayThatTheyWereNotSeen) {
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, FacesAndTreads(2).Update(), StandingAt(0.5, 0));
  ASSERT_EQ(map->staircases.size(), 1u);
  const auto predicted = PredictedIn(*map);
  ASSERT_EQ(predicted.size(), 4u);  // treads 3, 4, 5 and the strip of landing
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    EXPECT_EQ(predicted[i]->label, TerrainLabel::kStairTread);
    EXPECT_EQ(predicted[i]->staircase_id, map->staircases[0].id);
    EXPECT_EQ(predicted[i]->step_index, static_cast<int>(i) + 3);
    EXPECT_EQ(predicted[i]->num_observations, 0);
    EXPECT_EQ(predicted[i]->support, 0.0);
    EXPECT_GT(predicted[i]->plane_covariance(2, 2), 0.0);
  }
  std::vector<std::int64_t> of_staircase;
  for (const auto& region : map->regions)
    if (region->staircase_id) of_staircase.push_back(region->id);
  EXPECT_EQ(of_staircase, map->staircases[0].region_ids);
}

TEST(PredictedRegionsTest, AreReplacedWhenTheyAreSeenAndTheirIdsAreNeverUsedAgain) {
  TerrainLabeler labeler = MakeLabeler();
  const auto before = PredictedIn(*LabelOften(labeler, FacesAndTreads(2).Update(), StandingAt(0.5, 0)));
  // All treads are seen.
  const auto none = PredictedIn(*LabelOften(labeler, FacesAndTreads(5).Update(), StandingAt(0.5, 0)));
  ASSERT_EQ(none.size(), 1u);  // the strip of landing
  EXPECT_EQ(none[0]->id, before[3]->id);
  const auto again = PredictedIn(*LabelOften(labeler, FacesAndTreads(2).Update(), StandingAt(0.5, 0)));
  ASSERT_EQ(again.size(), 4u);
  std::vector<std::int64_t> ids;
  for (const auto& region : again) ids.push_back(region->id);
  EXPECT_EQ(std::count(ids.begin(), ids.end(), before[0]->id), 0);
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
}

TEST(PredictedRegionsTest, RestWhileNothingChanges) {
  TerrainLabeler labeler = MakeLabeler();
  const PolygonUpdate update = FacesAndTreads(2).Update();
  const auto first = PredictedIn(*LabelOften(labeler, update, StandingAt(0.5, 0), 10));
  EXPECT_EQ(first, PredictedIn(*LabelOften(labeler, update, StandingAt(0.5, 0), 20)));
}

}  // namespace
}  // namespace terrace
