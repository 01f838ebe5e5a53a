// SPDX-License-Identifier: BSD-3-Clause
#include "tools/terrain_words.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A camera half a metre above the floor that looks along x, 20 degrees down.
TerrainMap MapWithStairs() {
  TerrainMap map;
  map.T_world_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  map.T_world_left.rotate(Eigen::AngleAxisd(-0.35, Eigen::Vector3d::UnitX()));
  map.T_world_left.translation() = Eigen::Vector3d(2.0, 0.0, 0.5);
  auto floor = std::make_shared<TerrainRegion>();
  floor->id = 1;
  floor->label = TerrainLabel::kWalkway;
  floor->area_m2 = 4.0;
  map.regions.push_back(floor);
  Staircase stairs;
  stairs.id = 3;
  stairs.num_risers = 6;
  stairs.num_treads = 5;
  stairs.riser_m = 0.17;
  stairs.tread_m = 0.28;
  stairs.width_m = 1.4;
  stairs.foot_edge_world = {Eigen::Vector3d(3.2, 1.2, 0.0), Eigen::Vector3d(3.2, -0.2, 0.0)};
  map.staircases.push_back(stairs);
  return map;
}

TEST(TerrainWordsTest, TellsWhereAStaircaseIsAndWhatItIsLike) {
  const std::vector<std::string> words = ChangesInWords(nullptr, MapWithStairs());
  EXPECT_THAT(words,
              ElementsAre("walkway: 1 regions, 4.0 m2", AllOf(HasSubstr("staircase 3: 6 risers of 0.17 m"),
                                                              HasSubstr("1.2 m ahead, 0.5 m to the left"))));
}

TEST(TerrainWordsTest, TellsOnlyWhatChanged) {
  const auto before = std::make_shared<const TerrainMap>(MapWithStairs());
  TerrainMap after = *before;
  EXPECT_THAT(ChangesInWords(before, after), IsEmpty());
  after.staircases[0].riser_m += 0.001;
  EXPECT_THAT(ChangesInWords(before, after), IsEmpty()) << "a millimetre is no news";
  after.staircases[0].num_risers = 7;
  EXPECT_THAT(ChangesInWords(before, after), ElementsAre(HasSubstr("7 risers")));
  after.staircases.clear();
  after.regions.clear();
  EXPECT_THAT(ChangesInWords(before, after),
              ElementsAre("walkway: 0 regions, 0.0 m2", "staircase 3 is gone"));
}

TEST(TerrainWordsTest, NamesTroublesOfTheDaemonOnlyWhenThereAreAny) {
  Status status;
  status.state = DaemonState::kRunning;
  status.tracking = TrackingStatus::kTracking;
  EXPECT_THAT(StatusInWords(status), AllOf(HasSubstr("running, tracking"), Not(HasSubstr("gaps"))));
  status.state = DaemonState::kNoCalibration;
  status.num_imu_gaps = 2;
  status.reason = "nobody sends one";
  EXPECT_THAT(StatusInWords(status),
              AllOf(HasSubstr("no calibration"), HasSubstr("2 IMU gaps: nobody sends one")));
}

TEST(TerrainWordsTest, TellsPositionAndHeading) {
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.linear() = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_world_body.translation() = Eigen::Vector3d(1.0, -2.0, -0.001);
  EXPECT_EQ(PoseInWords(T_world_body, {0.3, 0.4, 0.0}),
            "at x 1.00 y -2.00 z 0.00 m, heading 90 deg, pitch 0 deg, 0.50 m/s");
}

}  // namespace
}  // namespace terrace
