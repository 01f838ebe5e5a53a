// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/image_scale.h"

#include <cstdint>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/lens.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

StereoCalibration WideRig() {
  StereoCalibration calibration;
  calibration.width = 1281;
  calibration.height = 720;
  calibration.left = {700, 702, 640.3, 355.8, DistortionModel::kRadialTangential, {-0.2, 0.05, 1e-3, -1e-3}};
  calibration.right = {698, 701, 633.1, 362.0, DistortionModel::kRadialTangential, {-0.21, 0.05, 0, 1e-3}};
  calibration.T_rawright_rawleft.translation() << -0.12, 0.0, 0.0;
  return calibration;
}

TEST(ImageScaleTest, KnowsOnlyHalvings) {
  EXPECT_THAT(ImageScaleConfig{}.Problems(), IsEmpty());
  EXPECT_THAT(ImageScaleConfig{0.25}.Problems(), IsEmpty());
  for (const double scale : {0.0, 0.3, 2.0, -0.5})
    EXPECT_THAT(ImageScaleConfig{scale}.Problems(), ElementsAre(HasSubstr("must be 1, 0.5 or 0.25")));
}

TEST(ImageScaleTest, LeavesEverythingAsItIsAtOne) {
  const StereoCalibration whole = WideRig(), same = Scaled(whole, {});
  EXPECT_EQ(same.width, whole.width);
  EXPECT_EQ(same.left.cx, whole.left.cx);
  StereoPair pair;
  pair.left = {3, 1, {10, 20, 40}};
  EXPECT_THAT(Scaled(pair, {}).left.data, ElementsAre(10, 20, 40));
}

TEST(ImageScaleTest, HalvedCamerasSeeAPointWhereItsPixelsHaveGone) {
  const StereoCalibration whole = WideRig();
  for (const int factor : {2, 4}) {
    const StereoCalibration scaled = Scaled(whole, {1.0 / factor});
    EXPECT_EQ(scaled.height, 720 / factor);
    EXPECT_EQ(scaled.width, factor == 2 ? 641 : 321);
    for (const auto& [raw, small] :
         {std::pair(whole.left, scaled.left), std::pair(whole.right, scaled.right)}) {
      const Eigen::Vector3d point(0.4, -0.3, 1.1);
      const Eigen::Vector2d at = *Lens(raw).Project(point), at_small = *Lens(small).Project(point);
      // Pixels 0 to factor - 1 have become pixel 0.
      EXPECT_NEAR(at_small.x(), (at.x() + 0.5) / factor - 0.5, 1e-9);
      EXPECT_NEAR(at_small.y(), (at.y() + 0.5) / factor - 0.5, 1e-9);
    }
    EXPECT_EQ(scaled.baseline_m(), whole.baseline_m());
  }
}

TEST(ImageScaleTest, HalvedPixelsAreMeansOfFour) {
  StereoPair pair;
  pair.left = {5, 3, {10, 20, 30, 40, 50, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120}};
  pair.right = {2, 2, {0, 0, 0, 8}};
  const StereoPair half = Scaled(pair, {0.5});
  EXPECT_EQ(half.left.width, 3);
  EXPECT_EQ(half.left.height, 2);
  EXPECT_THAT(half.left.data, ElementsAre(25, 45, 60, 85, 105, 120));
  EXPECT_THAT(half.right.data, ElementsAre(2));
  EXPECT_THAT(Scaled(pair, {0.25}).right.data, ElementsAre(2));  // no pixel is lost
}

TEST(ImageScaleTest, APairOfHalvedImagesIsRectifiedAsTheWholeOne) {
  const StereoCamera whole = Rectifier(WideRig()).camera();
  const StereoCamera half = Rectifier(Scaled(WideRig(), {0.5})).camera();
  EXPECT_EQ(half.width, 641);
  EXPECT_NEAR(half.fx, 0.5 * whole.fx, 0.01 * whole.fx);  // the view that both fill is found by whole pixels
  EXPECT_EQ(half.baseline_m, whole.baseline_m);
}

}  // namespace
}  // namespace terrace
