// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

StereoCalibration GoodCalibration() {
  StereoCalibration c;
  c.name = "sensor.yaml";
  c.width = 640;
  c.height = 480;
  c.left = c.right = {.fx = 400, .fy = 400, .cx = 319.5, .cy = 239.5, .distortion = {0, 0, 0, 0}};
  c.T_rawright_rawleft.translation().x() = -0.12;
  return c;
}

TEST(StereoCameraTest, ProjectsBackWhatItTriangulated) {
  const StereoCamera camera{640, 480, 400, 401, 319.5, 239.5, 0.12};
  const Eigen::Vector3d p_left = camera.Triangulate(100.25, 300.5, 20.0);
  EXPECT_NEAR(p_left.z(), 400 * 0.12 / 20.0, 1e-12);
  EXPECT_TRUE(camera.Project(p_left).isApprox(Eigen::Vector2d(100.25, 300.5), 1e-12));
  EXPECT_NEAR(camera.Disparity(p_left.z()), 20.0, 1e-12);
}

TEST(StereoCameraTest, DepthSigmaIsTheSlopeOfDepthOverDisparity) {
  const StereoCamera camera{640, 480, 400, 400, 319.5, 239.5, 0.12};
  const double step = 1e-4;
  const double slope = (camera.Depth(24.0 - step) - camera.Depth(24.0 + step)) / (2 * step);
  EXPECT_NEAR(camera.DepthSigma(2.0, 0.1), 0.1 * slope, 1e-6);
}

TEST(StereoCalibrationTest, AcceptsARectifiedPairAndKnowsThatItIsOne) {
  EXPECT_THAT(GoodCalibration().Problems(), IsEmpty());
  EXPECT_TRUE(GoodCalibration().rectified());
  StereoCalibration distorted = GoodCalibration();
  distorted.left.distortion[0] = -0.28;
  EXPECT_FALSE(distorted.rectified());
  StereoCalibration turned = GoodCalibration();
  turned.T_rawright_rawleft.rotate(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(turned.rectified());
}

TEST(StereoCalibrationTest, NamesSwappedCameras) {
  StereoCalibration c = GoodCalibration();
  c.T_rawright_rawleft.translation().x() = 0.12;
  EXPECT_THAT(c.Problems(), ElementsAre(HasSubstr("are left and right swapped?")));
}

TEST(StereoCalibrationTest, ListsEveryProblemAtOnce) {
  StereoCalibration c = GoodCalibration();
  c.left.fx = 4.0;
  c.left.fy = 4.0;
  c.right.cy = 5000;
  c.T_rawright_rawleft.translation().x() = 0.0;
  EXPECT_THAT(c.Problems(),
              ElementsAre(HasSubstr("left camera: fx = 4 px"), HasSubstr("left camera: fy = 4 px"),
                          HasSubstr("right camera: cy = 5000"), HasSubstr("baseline of 0 m")));
}

}  // namespace
}  // namespace terrace
