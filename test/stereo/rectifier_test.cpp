// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "core/check.h"
#include "textured_pair.h"

namespace terrace {
namespace {

constexpr int kRawWidth = 240;
constexpr int kRawHeight = 160;

/// Two cameras a little turned against each other, as a hand-built rig has them.
StereoCalibration TurnedPair(DistortionModel model, std::vector<double> distortion, double focal_px) {
  StereoCalibration c;
  c.name = "rig";
  c.width = kRawWidth;
  c.height = kRawHeight;
  c.left = {focal_px, 1.01 * focal_px, 117.3, 82.1, model, distortion};
  c.right = {1.02 * focal_px, focal_px, 123.9, 76.4, model, distortion};
  c.T_rawright_rawleft.linear() = (Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(-0.02, Eigen::Vector3d::UnitX()) *
                                   Eigen::AngleAxisd(0.015, Eigen::Vector3d::UnitZ()))
                                      .toRotationMatrix();
  c.T_rawright_rawleft.translation() = Eigen::Vector3d(-0.11, 0.004, -0.003);
  return c;
}

StereoCalibration RadialTangentialPair() {
  return TurnedPair(DistortionModel::kRadialTangential, {-0.28, 0.08, 0.0012, -0.0009}, 150.0);
}

/// 150 deg wide.
StereoCalibration FisheyePair() {
  return TurnedPair(DistortionModel::kEquidistant, {0.01, -0.02, 0.008, -0.002}, 90.0);
}

/// One camera above the other, a little turned as well.
StereoCalibration PairAboveEachOther(double y_of_right) {
  StereoCalibration c = RadialTangentialPair();
  c.T_rawright_rawleft.translation() = Eigen::Vector3d(0.005, y_of_right, 0.002);
  return c;
}

/// 195 deg wide.
StereoCalibration DoubleSpherePair() {
  return TurnedPair(DistortionModel::kDoubleSphere, {-0.17, 0.59}, 75.0);
}

/// A wall in front of the left raw camera, z = 2 m + 0.2 x, painted with waves.
class PaintedWall {
 public:
  double Grey(const Eigen::Vector3d& eye_rawleft, const Eigen::Vector3d& ray_rawleft) const {
    const Eigen::Vector3d normal(-0.2, 0.0, 1.0);
    const double along = (2.0 - normal.dot(eye_rawleft)) / normal.dot(ray_rawleft);
    const Eigen::Vector3d p = eye_rawleft + along * ray_rawleft;
    return 128.0 + 30.0 * texture_(12.0 * p.x(), 12.0 * p.y());
  }

 private:
  WaveTexture texture_{7};
};

/// The ray (x, y, 1) of a pixel: the closed form of the model's paper. Zero where it looks behind.
cv::Point2d UnprojectDoubleSphere(const RawCamera& camera, const cv::Point2d& pixel) {
  const double xi = camera.distortion[0], alpha = camera.distortion[1];
  const double mx = (pixel.x - camera.cx) / camera.fx, my = (pixel.y - camera.cy) / camera.fy;
  const double r2 = mx * mx + my * my;
  if (r2 > 1.0 / (2 * alpha - 1)) return {};
  const double mz = (1 - alpha * alpha * r2) / (alpha * std::sqrt(1 - (2 * alpha - 1) * r2) + 1 - alpha);
  const double scale = (mz * xi + std::sqrt(mz * mz + (1 - xi * xi) * r2)) / (mz * mz + r2);
  const double z = scale * mz - xi;
  return z > 0.0 ? cv::Point2d(scale * mx / z, scale * my / z) : cv::Point2d();
}

/// What a raw camera sees of the wall. The lens is OpenCV's undistortion, not ours.
GrayImage RenderRaw(const RawCamera& camera, const Eigen::Isometry3d& T_rawleft_raw) {
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<cv::Point2d> pixels, rays;
  for (int v = 0; v < kRawHeight; ++v) {
    for (int u = 0; u < kRawWidth; ++u) pixels.emplace_back(u, v);
  }
  if (camera.model == DistortionModel::kDoubleSphere) {
    for (const cv::Point2d& pixel : pixels) rays.push_back(UnprojectDoubleSphere(camera, pixel));
  } else if (camera.model == DistortionModel::kEquidistant) {
    const cv::Vec4d k(camera.distortion.data());
    cv::fisheye::undistortPoints(pixels, rays, K, k);
  } else {
    cv::undistortPoints(pixels, rays, K, camera.distortion, cv::noArray(), cv::noArray(),
                        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12));
  }
  const PaintedWall wall;
  GrayImage image{kRawWidth, kRawHeight, {}};
  for (const cv::Point2d& ray : rays) {
    const double grey =
        wall.Grey(T_rawleft_raw.translation(), T_rawleft_raw.linear() * Eigen::Vector3d(ray.x, ray.y, 1));
    image.data.push_back(static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0) + 0.5));
  }
  return image;
}

/// What an ideal camera at that place would see.
cv::Mat1d RenderIdeal(const StereoCamera& camera, const Eigen::Isometry3d& T_rawleft_rect) {
  const PaintedWall wall;
  cv::Mat1d image(camera.height, camera.width);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      image(v, u) = wall.Grey(T_rawleft_rect.translation(), T_rawleft_rect.linear() * ray);
    }
  }
  return image;
}

/// The largest shift between two images [px], found block by block as optical flow is, beside a change of
/// contrast and brightness: interpolation dims fine waves.
double LargestShift(const cv::Mat1b& image, const cv::Mat1d& ideal) {
  constexpr int kBlock = 80;
  double largest = 0.0;
  for (int top = 0; top + kBlock <= image.rows; top += kBlock) {
    for (int left = 0; left + kBlock <= image.cols; left += kBlock) {
      Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
      Eigen::Vector4d b = Eigen::Vector4d::Zero();
      for (int v = top + 1; v < top + kBlock - 1; ++v) {
        for (int u = left + 1; u < left + kBlock - 1; ++u) {
          const Eigen::Vector4d slope(0.5 * (ideal(v, u + 1) - ideal(v, u - 1)),
                                      0.5 * (ideal(v + 1, u) - ideal(v - 1, u)), ideal(v, u) - 128.0, 1.0);
          A += slope * slope.transpose();
          b += slope * (image(v, u) - ideal(v, u));
        }
      }
      largest = std::max(largest, A.ldlt().solve(b).head<2>().norm());
    }
  }
  return largest;
}

class RectifierTest : public testing::TestWithParam<StereoCalibration> {};

TEST_P(RectifierTest, ShowsWhatIdealCamerasWouldSee) {
  const StereoCalibration& calibration = GetParam();
  ASSERT_TRUE(calibration.Problems().empty());
  StereoPair pair;
  pair.t_capture = {17};
  pair.left = RenderRaw(calibration.left, Eigen::Isometry3d::Identity());
  pair.right = RenderRaw(calibration.right, calibration.T_rawright_rawleft.inverse());

  const Rectifier rectifier(calibration);
  const StereoFrame frame = rectifier.Rectify(5, pair);
  EXPECT_EQ(frame.frame_id, 5);
  EXPECT_EQ(frame.t_capture.ns, 17);
  const StereoCamera& camera = rectifier.camera();
  EXPECT_EQ(frame.left.size(), cv::Size(camera.width, camera.height));
  EXPECT_EQ(camera.width * camera.height, kRawWidth * kRawHeight);
  EXPECT_NEAR(camera.baseline_m, calibration.baseline_m(), 1e-12);

  Eigen::Isometry3d T_rawleft_left = Eigen::Isometry3d::Identity();
  T_rawleft_left.linear() = rectifier.R_rect_raw().transpose();
  const Eigen::Isometry3d T_rawleft_right = T_rawleft_left * Eigen::Translation3d(camera.baseline_m, 0, 0);
  // The right camera's centre lies on the x axis of the rectified left one.
  EXPECT_TRUE(
      T_rawleft_right.translation().isApprox(calibration.T_rawright_rawleft.inverse().translation(), 1e-9));
  // Grey values are whole numbers and interpolated: what is left of them after a block's average.
  constexpr double kMaxShiftPx = 0.03;
  EXPECT_LT(LargestShift(frame.left, RenderIdeal(camera, T_rawleft_left)), kMaxShiftPx);
  EXPECT_LT(LargestShift(frame.right, RenderIdeal(camera, T_rawleft_right)), kMaxShiftPx);
}

TEST_P(RectifierTest, FillsBothImagesWithValidPixels) {
  const Rectifier rectifier(GetParam());
  StereoPair white;
  white.left = white.right = {kRawWidth, kRawHeight, std::vector<std::uint8_t>(kRawWidth * kRawHeight, 255)};
  const StereoFrame frame = rectifier.Rectify(0, white);
  EXPECT_EQ(cv::countNonZero(frame.left == 255), kRawWidth * kRawHeight);
  EXPECT_EQ(cv::countNonZero(frame.right == 255), kRawWidth * kRawHeight);
  const double zoom = rectifier.camera().fx / GetParam().left.fx;
  EXPECT_GE(zoom, 0.79);
  EXPECT_LE(zoom, 1.2);
}

TEST(RectifierFoldTest, ShowsNoGhostsWhereTheLensPolynomialTurnsBack) {
  // 1 - 0.4 r^2 turns back at r = 0.91, well inside the corners of the view.
  StereoCalibration calibration = TurnedPair(DistortionModel::kRadialTangential, {-0.4, 0, 0, 0}, 100.0);
  StereoPair white;
  white.left = white.right = {kRawWidth, kRawHeight, std::vector<std::uint8_t>(kRawWidth * kRawHeight, 255)};
  const Rectifier rectifier(calibration);
  const StereoFrame frame = rectifier.Rectify(0, white);
  const StereoCamera& camera = rectifier.camera();
  for (int v = 0; v < kRawHeight; ++v) {
    for (int u = 0; u < kRawWidth; ++u) {
      const Eigen::Vector3d ray_raw =
          rectifier.R_rect_raw().transpose() *
          Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const double tangent = ray_raw.head<2>().norm() / ray_raw.z();
      if (tangent > 0.92) {
        EXPECT_EQ(frame.left(v, u), 0) << u << " " << v;
      }
      if (tangent < 0.89) {
        EXPECT_EQ(frame.left(v, u), 255) << u << " " << v;
      }
    }
  }
}

constexpr std::array kRigNames = {"RadialTangential", "Equidistant", "DoubleSphere", "RightBelow",
                                  "RightAbove"};

INSTANTIATE_TEST_SUITE_P(Rigs, RectifierTest,
                         testing::Values(RadialTangentialPair(), FisheyePair(), DoubleSpherePair(),
                                         PairAboveEachOther(-0.11), PairAboveEachOther(0.11)),
                         [](const auto& rig) { return kRigNames[rig.index]; });

TEST(RectifierTurnTest, TurnsAPairAboveEachOtherByAQuarter) {
  for (const double y : {-0.11, 0.11}) {
    const Rectifier rectifier(PairAboveEachOther(y));
    EXPECT_EQ(rectifier.camera().width, kRawHeight);
    EXPECT_EQ(rectifier.camera().height, kRawWidth);
    // The raw camera's down lies along the rows; both still look the same way.
    const Eigen::Matrix3d& R = rectifier.R_rect_raw();
    EXPECT_GT(std::abs(R(0, 1)), 0.99);
    EXPECT_GT(R(2, 2), 0.99);
  }
}

TEST(RectifierViewTest, TakesFocalLengthAndSizeAsConfigured) {
  RectifierConfig config;
  config.rectified_focal_px = 120.0;
  config.rectified_size = "320x200";
  ASSERT_TRUE(config.Problems().empty());
  const StereoCalibration calibration = FisheyePair();
  EXPECT_EQ(RectifiedSize(calibration, config), std::pair(320, 200));
  StereoPair pair;
  pair.left = RenderRaw(calibration.left, Eigen::Isometry3d::Identity());
  pair.right = RenderRaw(calibration.right, calibration.T_rawright_rawleft.inverse());
  const Rectifier rectifier(calibration, config);
  EXPECT_EQ(rectifier.camera().fx, 120.0);
  const StereoFrame frame = rectifier.Rectify(0, pair);
  ASSERT_EQ(frame.left.size(), cv::Size(320, 200));
  Eigen::Isometry3d T_rawleft_left = Eigen::Isometry3d::Identity();
  T_rawleft_left.linear() = rectifier.R_rect_raw().transpose();
  // The raw pixels, which interpolation blurs, are a third larger than these.
  constexpr double kMaxShiftPx = 0.03 * 120.0 / 90.0;
  EXPECT_LT(LargestShift(frame.left, RenderIdeal(rectifier.camera(), T_rawleft_left)), kMaxShiftPx);
}

TEST(RectifierViewTest, ShowsTheSameViewInSmallerImages) {
  RectifierConfig half;
  half.rectified_size = "120x80";
  const StereoCamera whole = Rectifier(RadialTangentialPair()).camera();
  const StereoCamera small = Rectifier(RadialTangentialPair(), half).camera();
  EXPECT_NEAR(small.fx, 0.5 * whole.fx, 0.01 * whole.fx);
}

TEST(RectifierViewTest, SaysWhichSettingCannotBe) {
  RectifierConfig config;
  config.rectified_focal_px = -3.0;
  config.rectified_size = "640 by 480";
  EXPECT_EQ(config.Problems().size(), 2u);
  config.rectified_size = "640x480x3";
  EXPECT_EQ(config.Problems().size(), 2u);
}

TEST(RectifierPassThroughTest, HandsARectifiedPairOnUnchanged) {
  StereoCalibration calibration;
  calibration.width = 64;
  calibration.height = 48;
  calibration.left =
      calibration.right = {50, 51, 31.5, 23.5, DistortionModel::kRadialTangential, {0, 0, 0, 0}};
  calibration.T_rawright_rawleft.translation().x() = -0.12;
  const Rectifier rectifier(calibration);
  EXPECT_TRUE(rectifier.R_rect_raw().isIdentity(0.0));
  EXPECT_EQ(rectifier.camera().fy, 51);
  StereoPair pair;
  pair.left = pair.right = {64, 48, std::vector<std::uint8_t>(64 * 48)};
  for (std::size_t i = 0; i < pair.left.data.size(); ++i)
    pair.left.data[i] = static_cast<std::uint8_t>(i * 7);
  const StereoFrame frame = rectifier.Rectify(0, pair);
  EXPECT_TRUE(std::equal(pair.left.data.begin(), pair.left.data.end(), frame.left.begin()));
}

TEST(RectifierPassThroughTest, MovesAPairWithDifferentPrincipalPointsOntoOneCamera) {
  // As Middlebury calibrates: rectified rows, but disparity zero is not infinity.
  StereoCalibration calibration;
  calibration.width = 64;
  calibration.height = 48;
  calibration.left = calibration.right = {50, 50, 30.0, 24.0, DistortionModel::kRadialTangential, {}};
  calibration.right.cx = 36.0;
  calibration.T_rawright_rawleft.translation().x() = -0.12;
  StereoPair pair;
  pair.left = pair.right = {64, 48, std::vector<std::uint8_t>(64 * 48)};
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      pair.left.data[static_cast<std::size_t>(64 * v + u)] = static_cast<std::uint8_t>(3 * u);
      pair.right.data[static_cast<std::size_t>(64 * v + u)] = static_cast<std::uint8_t>(3 * (u - 6));
    }
  }
  // Both show the same infinitely far slope of grey: rectified, they must agree.
  const StereoFrame frame = Rectifier(calibration).Rectify(0, pair);
  cv::Mat1b difference;
  cv::absdiff(frame.left.colRange(8, 56), frame.right.colRange(8, 56), difference);
  EXPECT_LE(*std::max_element(difference.begin(), difference.end()), 1);
}

TEST(RectifierErrorTest, ListsEveryProblemOfTheCalibration) {
  StereoCalibration calibration = RadialTangentialPair();
  calibration.left.fx = 1;
  calibration.T_rawright_rawleft.translation().x() = 0.11;
  try {
    Rectifier rectifier(calibration);
    FAIL() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("fx = 1"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("swapped"), std::string::npos);
  }
}

TEST(RectifierErrorTest, TakesImagesOfAnotherSizeForABrokenPromise) {
  StereoPair pair;
  pair.left = pair.right = {8, 8, std::vector<std::uint8_t>(64)};
  EXPECT_THROW(Rectifier(RadialTangentialPair()).Rectify(0, pair), CheckError);
}

}  // namespace
}  // namespace terrace
