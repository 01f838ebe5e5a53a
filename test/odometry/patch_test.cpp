// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/patch.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "odometry/patch_alignment.h"
#include "odometry/stereo_alignment.h"
#include "textured_image.h"

namespace terrace {
namespace {

template <typename Grey>
cv::Mat1b Render(Grey grey) {
  cv::Mat1b image(80, 120);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) image(v, u) = cv::saturate_cast<std::uint8_t>(grey(u, v));
  return image;
}

/// What a template samples, one at a time.
float PlainBilinear(const cv::Mat1b& image, float x, float y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const float fx = x - static_cast<float>(u), fy = y - static_cast<float>(v);
  const auto Across = [&](int row) {
    const float a = image(row, u), b = image(row, u + 1);
    return a + fx * (b - a);
  };
  return Across(v) + fy * (Across(v + 1) - Across(v));
}

TEST(PatchTest, SamplesTheSameBitsAsOneAtATime) {
  cv::Mat1b image = Render([](double u, double v) { return Texture(u, v); });
  image(cv::Rect(50, 30, 9, 7)).setTo(255);
  const cv::Mat1b part = image(cv::Rect(3, 2, 110, 70));  // rows farther apart than they are long
  Eigen::Matrix2f A;
  A << 0.83f, 0.17f, -0.06f, 1.21f;
  for (const Eigen::Vector2f& centre : {Eigen::Vector2f(50.3f, 33.8f), Eigen::Vector2f(20.0f, 21.49f)}) {
    PatchTemplate patch;
    ASSERT_TRUE(ExtractTemplate(part, centre, A, patch));
    const auto Sample = [&](float du, float dv) {
      return PlainBilinear(part, centre.x() + A(0, 0) * du + A(0, 1) * dv,
                           centre.y() + A(1, 0) * du + A(1, 1) * dv);
    };
    float mean = 0.0f;
    for (int k = 0; k < PatchTemplate::kArea; ++k)
      mean += Sample(PatchTemplate::Offset(k % PatchTemplate::kSize),
                     PatchTemplate::Offset(k / PatchTemplate::kSize));
    mean /= PatchTemplate::kArea;
    for (int k = 0; k < PatchTemplate::kArea; ++k) {
      const float du = PatchTemplate::Offset(k % PatchTemplate::kSize);
      const float dv = PatchTemplate::Offset(k / PatchTemplate::kSize);
      EXPECT_EQ(patch.value[k], Sample(du, dv) - mean) << k;
      EXPECT_EQ(patch.gradient_u[k], 0.5f * (Sample(du + 1, dv) - Sample(du - 1, dv))) << k;
      EXPECT_EQ(patch.gradient_v[k], 0.5f * (Sample(du, dv + 1) - Sample(du, dv - 1))) << k;
    }
  }
}

TEST(PatchTest, FindsAShiftToAFewHundredthsOfAPixelUnderOtherBrightnessAndContrast) {
  const cv::Mat1b first = Render([](double u, double v) { return Texture(u, v); });
  const cv::Mat1b second = Render([](double u, double v) { return 0.6 * Texture(u - 1.3, v + 0.7) + 40.0; });
  PatchTemplate patch;
  ASSERT_TRUE(ExtractTemplate(first, {60, 40}, Eigen::Matrix2f::Identity(), patch));
  Alignment found;
  ASSERT_TRUE(Align(second, patch, {60, 40}, 10, 5.0f, found));
  EXPECT_NEAR(found.position.x(), 61.3, 0.05);
  EXPECT_NEAR(found.position.y(), 39.3, 0.05);
  EXPECT_NEAR(found.gain, 0.6, 0.03);
  EXPECT_GT(found.agreement, 0.98f);
}

TEST(PatchTest, FindsAWarpedPatchWhenTheWarpIsKnown) {
  Eigen::Matrix2f A;  // from the second image to the first
  A << 0.8f, 0.1f, -0.05f, 1.2f;
  const cv::Mat1b first = Render([](double u, double v) { return Texture(u, v); });
  const cv::Mat1b second = Render([&](double u, double v) {
    const Eigen::Vector2f p =
        A * Eigen::Vector2f(static_cast<float>(u) - 50.5f, static_cast<float>(v) - 41.0f);
    return Texture(60.0 + p.x(), 40.0 + p.y());
  });
  PatchTemplate patch;
  ASSERT_TRUE(ExtractTemplate(first, {60, 40}, A, patch));
  Alignment found;
  ASSERT_TRUE(Align(second, patch, {51, 40}, 10, 5.0f, found));
  EXPECT_NEAR(found.position.x(), 50.5, 0.05);
  EXPECT_NEAR(found.position.y(), 41.0, 0.05);
}

/// So bright that a third is too much for the camera.
double TooBright(double u, double v) { return 2.2 * Texture(u, v) - 60.0; }

/// Looks for patches all over an image in one that was shifted by (1.3, -0.7).
struct ShiftErrors {
  int num_found = 0;
  double rms_px = 0.0;
  double max_px = 0.0;

  ShiftErrors(const cv::Mat1b& first, const cv::Mat1b& second) {
    double sum = 0.0;
    for (int u = 20; u <= 100; u += 10) {
      for (int v = 20; v <= 60; v += 10) {
        const Eigen::Vector2f centre(static_cast<float>(u), static_cast<float>(v));
        PatchTemplate patch;
        Alignment found;
        if (!ExtractTemplate(first, centre, Eigen::Matrix2f::Identity(), patch) ||
            !Align(second, patch, centre, 10, 5.0f, found) || found.agreement < 0.9f)
          continue;
        const double error = (found.position - centre - Eigen::Vector2f(1.3f, -0.7f)).norm();
        ++num_found;
        sum += error * error;
        max_px = std::max(max_px, error);
      }
    }
    rms_px = std::sqrt(sum / std::max(num_found, 1));
  }
};

TEST(PatchTest, IsNotLedAstrayByWhatIsTooBrightInTheImage) {
  const ShiftErrors errors(Render([](double u, double v) { return Texture(u, v); }),
                           Render([](double u, double v) { return TooBright(u - 1.3, v + 0.7); }));
  EXPECT_GT(errors.num_found, 25);
  EXPECT_LT(errors.rms_px, 0.05);
  EXPECT_LT(errors.max_px, 0.25);
}

TEST(PatchTest, IsNotLedAstrayByWhatIsTooBrightInTheTemplate) {
  const ShiftErrors errors(Render([](double u, double v) { return TooBright(u, v); }),
                           Render([](double u, double v) { return Texture(u - 1.3, v + 0.7); }));
  EXPECT_GT(errors.num_found, 25);
  EXPECT_LT(errors.rms_px, 0.05);
  EXPECT_LT(errors.max_px, 0.25);
}

TEST(PatchTest, RefusesAPatchWithoutACornerOrOutsideTheImage) {
  const cv::Mat1b edge = Render([](double u, double) { return u < 60 ? 50.0 : 150.0; });
  PatchTemplate patch;
  EXPECT_FALSE(ExtractTemplate(edge, {60, 40}, Eigen::Matrix2f::Identity(), patch));
  const cv::Mat1b image = Render([](double u, double v) { return Texture(u, v); });
  EXPECT_FALSE(ExtractTemplate(image, {3, 40}, Eigen::Matrix2f::Identity(), patch));
}

TEST(PatchTest, FitsDisparityAndSlantTogether) {
  // Disparity 12.4 px at (60, 40), growing by 0.25 px a row, as on a floor seen from a low camera.
  const cv::Mat1b left = Render([](double u, double v) { return Texture(u, v); });
  const cv::Mat1b right = Render(
      [](double u, double v) { return Texture((u + 12.4 + 0.25 * (v - 40.0) - 0.05 * 60.0) / 0.95, v); });
  StereoAlignment found;
  found.disparity_px = 11.0f;
  ASSERT_TRUE(AlignStereo(left, right, {60, 40}, 0.0f, found));
  EXPECT_NEAR(found.disparity_px, 12.4, 0.05);
  EXPECT_NEAR(found.gradient_u, 0.05, 0.02);
  EXPECT_NEAR(found.gradient_v, 0.25, 0.02);
  EXPECT_NEAR(found.vertical_px, 0.0, 0.05);
}

}  // namespace
}  // namespace terrace
