// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/self_mask.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "daemon/config.h"
#include "datasets/image_file.h"
#include "stereo/rectifier.h"
#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

constexpr int kMaskWidth = 64, kMaskHeight = 48;

/// Looks along the body's x axis, 0.3 m in front of it and 0.1 m above, nose down by 30 deg.
StereoCalibration RigOnBody() {
  StereoCalibration calibration;
  calibration.width = kMaskWidth;
  calibration.height = kMaskHeight;
  calibration.left.fx = calibration.left.fy = 40.0;
  calibration.left.cx = 31.5;
  calibration.left.cy = 23.5;
  calibration.right = calibration.left;
  calibration.T_rawright_rawleft.translation().x() = -0.1;
  Eigen::Matrix3d R_level;
  R_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(M_PI / 6.0, Eigen::Vector3d::UnitY()) * R_level;
  T.translation() = Eigen::Vector3d(0.3, 0.0, 0.1);
  calibration.T_body_rawleft = T;
  return calibration;
}

/// The slow obvious way: go along the ray of a pixel in steps of a millimetre.
template <typename Inside>
cv::Mat1b MaskByWalking(const StereoCalibration& calibration, Inside inside) {
  const StereoCamera camera = Rectifier(calibration).camera();
  cv::Mat1b mask(camera.height, camera.width, std::uint8_t{255});
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d p((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      for (double t = 0.0; t < 2.0 && mask(v, u) != 0; t += 0.001)
        if (inside(*calibration.T_body_rawleft * (t * p.normalized()))) mask(v, u) = 0;
    }
  }
  return mask;
}

/// Pixels on the outline alone may differ: a step may miss an edge by its length.
void ExpectTheSameBut(const cv::Mat1b& a, const cv::Mat1b& b, double share) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_LE(cv::countNonZero(a != b), share * static_cast<double>(a.total()));
  EXPECT_GT(cv::countNonZero(a == 0), 50) << "something is hidden";
  EXPECT_GT(cv::countNonZero(a), 50) << "something is not";
}

TEST(SelfMaskTest, HidesWhatTheCameraSeesOfABox) {
  PipelineConfig config;
  config.self_mask.self_boxes_m = {0.7, 0.3, -0.5, 0.4, 0.1, -0.1};
  const StereoCalibration calibration = RigOnBody();
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0.4, 0.1, -0.5), Eigen::Vector3d(0.7, 0.3, -0.1));
  ExpectTheSameBut(LoadSelfMask(config, calibration),
                   MaskByWalking(calibration, [&](const Eigen::Vector3d& p) { return box.contains(p); }),
                   0.005);
}

TEST(SelfMaskTest, HidesWhatTheCameraSeesOfACapsule) {
  PipelineConfig config;
  config.self_mask.self_capsules_m = {0.5, -0.2, 0.0, 0.7, -0.1, -0.4, 0.06};
  const StereoCalibration calibration = RigOnBody();
  const Eigen::Vector3d a(0.5, -0.2, 0.0), b(0.7, -0.1, -0.4);
  const auto inside = [&](const Eigen::Vector3d& p) {
    const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (a + s * (b - a) - p).norm() <= 0.06;
  };
  ExpectTheSameBut(LoadSelfMask(config, calibration), MaskByWalking(calibration, inside), 0.005);
}

TEST(SelfMaskTest, HidesNothingBehindTheCamera) {
  PipelineConfig config;
  config.self_mask.self_boxes_m = {-0.5, -0.3, -0.3, 0.2, 0.3, 0.3};
  config.self_mask.self_capsules_m = {-0.5, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1};
  EXPECT_EQ(cv::countNonZero(LoadSelfMask(config, RigOnBody())), kMaskWidth * kMaskHeight);
}

TEST(SelfMaskTest, RefusesPartsWithoutABodyOrAroundTheCamera) {
  PipelineConfig config;
  config.self_mask.self_boxes_m = {-0.5, -0.3, -0.3, 0.5, 0.3, 0.3};
  EXPECT_THROW(LoadSelfMask(config, RigOnBody()), ConfigError);
  config.self_mask.self_boxes_m = {0.4, 0.1, -0.5, 0.7, 0.3, -0.1};
  StereoCalibration without = RigOnBody();
  without.T_body_rawleft.reset();
  EXPECT_THROW(LoadSelfMask(config, without), ConfigError);
  StereoCalibration rolled = RigOnBody();  // as the axes of an IMU may be
  rolled.T_body_rawleft =
      Eigen::Isometry3d(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX())) * *rolled.T_body_rawleft;
  EXPECT_THROW(LoadSelfMask(config, rolled), ConfigError);
  config.mounting.source = "body";
  EXPECT_NO_THROW(LoadSelfMask(config, rolled));
  config.mounting.source = "auto";
  config.mounting.pitch_deg = 30.0;
  config.mounting.position_m = {0.3, 0.0, 0.1};
  EXPECT_EQ(cv::countNonZero(LoadSelfMask(config, without) != LoadSelfMask(config, RigOnBody())), 0);
}

TEST(SelfMaskTest, TakesAMaskInRawOrInRectifiedPixels) {
  const TemporaryFolder folder;
  const std::string png = (folder.path() / "mask.png").string();
  // One camera above the other: the rectified pair is turned by 90 deg.
  StereoCalibration calibration = RigOnBody();
  calibration.T_rawright_rawleft.translation() = Eigen::Vector3d(0.0, -0.1, 0.0);
  const Rectifier rectifier(calibration);
  ASSERT_EQ(rectifier.camera().width, kMaskHeight) << "turned";
  GrayImage raw{kMaskWidth, kMaskHeight, std::vector<std::uint8_t>(kMaskWidth * kMaskHeight, 255)};
  for (int v = 0; v < kMaskHeight / 2; ++v)
    for (int u = 0; u < kMaskWidth / 4; ++u) raw.data[static_cast<std::size_t>(v * kMaskWidth + u)] = 0;
  WritePng(png, raw);
  PipelineConfig config;
  config.terrain.robot.self_mask_png = png;
  EXPECT_THROW(LoadSelfMask(config, calibration), ConfigError)
      << "of the raw images' size, taken for rectified";
  config.self_mask.self_mask_pixels = "raw";
  const cv::Mat1b mask = LoadSelfMask(config, calibration);
  // Where a hidden and a seen raw pixel come to lie.
  const auto at = [&](int u, int v) {
    const Eigen::Vector3d p =
        rectifier.R_rect_raw() * Eigen::Vector3d((u - 31.5) / 40.0, (v - 23.5) / 40.0, 1.0);
    const StereoCamera& c = rectifier.camera();
    const auto x = std::lround(c.fx * p.x() / p.z() + c.cx), y = std::lround(c.fy * p.y() / p.z() + c.cy);
    return mask(static_cast<int>(y), static_cast<int>(x));
  };
  EXPECT_EQ(at(6, 10), 0);
  EXPECT_EQ(at(20, 10), 255);
  EXPECT_EQ(at(6, 30), 255);
  EXPECT_EQ(at(50, 30), 255);
}

TEST(SelfMaskTest, SaysWhatIsWrongWithTheSettings) {
  SelfMaskConfig config;
  EXPECT_TRUE(config.Problems().empty());
  config.self_mask_pixels = "body";
  config.self_boxes_m = {1, 2, 3};
  config.self_capsules_m = {0, 0, 0, 1, 0, 0, 0};
  const auto problems = config.Problems();
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_THAT(problems[0], HasSubstr("self_mask_pixels = \"body\" must be"));
  EXPECT_THAT(problems[1], HasSubstr("six numbers"));
  EXPECT_THAT(problems[2], HasSubstr("radii above 0"));
}

TEST(SelfMaskTest, SaysSoWhenNothingIsLeftToSee) {
  const TemporaryFolder folder;
  const std::string png = (folder.path() / "black.png").string();
  WritePng(png, GrayImage{kMaskWidth, kMaskHeight, std::vector<std::uint8_t>(kMaskWidth * kMaskHeight, 0)});
  PipelineConfig config;
  config.terrain.robot.self_mask_png = png;
  try {
    LoadSelfMask(config, RigOnBody());
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("leaves less than 2 % of the image to see"));
  }
}

}  // namespace
}  // namespace terrace
