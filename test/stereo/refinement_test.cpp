// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/refinement.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/unknown_disparity.h"
#include "test/every_target.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

bool SameBits(const cv::Mat1f& a, const cv::Mat1f& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
           return std::memcmp(&x, &y, sizeof(float)) == 0 || (std::isnan(x) && std::isnan(y));
         });
}

/// The plane's disparities, each off by up to `error`, one in ten unknown.
cv::Mat1f RoughDisparity(int width, int height, const SlantedPlane& plane, double error) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> offset(-error, error);
  cv::Mat1f rough(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      rough(v, u) =
          random() % 10 == 0 ? kUnknownDisparity : static_cast<float>(plane.At(u, v) + offset(random));
  return rough;
}

TEST(RefinementTest, FindsAPlaneFromRoughDisparitiesDespiteGainAndOffset) {
  const SlantedPlane plane{6.2, 0.02, 0.03};
  const Photometry light = {.contrast = 30, .mean = 110, .gain_right = 0.9, .offset_right = 12, .noise = 1.0};
  const StereoFrame frame = RenderPlane(140, 60, plane, light);
  cv::Mat1f disparity = RoughDisparity(140, 60, plane, 0.5), sigma;
  Refiner({}).Refine(frame.left, frame.right, disparity, &sigma);
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int v = 3; v < 57; ++v)
    for (int u = 20; u < 137; ++u) {
      EXPECT_EQ(std::isnan(disparity(v, u)), std::isnan(sigma(v, u)));
      if (std::isnan(disparity(v, u))) continue;
      const double error = disparity(v, u) - plane.At(u, v);
      sum += error, squares += error * error, ++count;
    }
  EXPECT_NEAR(sum / count, 0.0, 0.01);  // a few hundred independent windows of 0.06 px each
  EXPECT_LT(std::sqrt(squares / count), 0.06);
}

TEST(RefinementTest, FindsASteepPlane) {
  // Five rows of a window differ by 3.6 px; each row's disparities are off together, as matching leaves them.
  const SlantedPlane plane{12.2, 0.01, 0.9};
  const StereoFrame frame = RenderPlane(240, 60, plane, {.contrast = 30, .noise = 1.0});
  std::mt19937 random(3);
  std::uniform_real_distribution<float> offset(-0.5f, 0.5f);
  cv::Mat1f rough = RoughDisparity(240, 60, plane, 0.3);
  for (int v = 0; v < 60; ++v) {
    const float off = offset(random);
    for (int u = 0; u < 240; ++u) rough(v, u) += off;
  }
  SteepSurfaces steep;
  steep.Measure(rough);
  const auto rms_of = [&](const Steepness& steepness) {
    cv::Mat1f disparity = rough.clone(), sigma;
    Refiner({}).Refine(frame.left, frame.right, disparity, &sigma, steepness);
    double squares = 0.0;
    int count = 0;
    for (int v = 4; v < 56; ++v)
      for (int u = 80; u < 237; ++u)
        if (!std::isnan(disparity(v, u))) squares += std::pow(disparity(v, u) - plane.At(u, v), 2), ++count;
    return std::sqrt(squares / count);
  };
  EXPECT_LT(rms_of({&steep, 1}), 0.12);
  EXPECT_GT(rms_of({}), 0.3);  // what the slope is for
}

/// 68 % quantile of error / sigma.
double ErrorInSigmas(const SlantedPlane& plane, const Photometry& light, double error_given_px) {
  const StereoFrame frame = RenderPlane(400, 120, plane, light);
  cv::Mat1f disparity = RoughDisparity(400, 120, plane, error_given_px), sigma;
  Refiner({}).Refine(frame.left, frame.right, disparity, &sigma);
  std::vector<double> errors;
  for (int v = 3; v < 117; ++v)
    for (int u = 30; u < 397; ++u)
      if (!std::isnan(disparity(v, u)))
        errors.push_back(std::abs(disparity(v, u) - plane.At(u, v)) / sigma(v, u));
  const auto quantile =
      errors.begin() + static_cast<std::ptrdiff_t>(0.68 * static_cast<double>(errors.size()));
  std::nth_element(errors.begin(), quantile, errors.end());
  return *quantile;
}

TEST(RefinementTest, KnowsHowWrongItMayBeAtEveryTextureAndNoise) {
  for (const Photometry& light : std::vector<Photometry>{{.contrast = 25, .mean = 110, .noise = 1.0},
                                                         {.contrast = 15, .mean = 110, .noise = 1.0},
                                                         {.contrast = 15, .mean = 110, .noise = 3.0},
                                                         {.contrast = 5, .mean = 40, .noise = 1.0}}) {
    // These textures are smooth: interpolated better than those that sigma is measured on.
    const double errors = ErrorInSigmas({16.3, 0.02, 0.03}, light, 0.4);
    EXPECT_GT(errors, 0.7) << light.contrast << " " << light.noise;
    EXPECT_LT(errors, 1.25) << light.contrast << " " << light.noise;
  }
}

TEST(RefinementTest, IsHardlyDrawnToHalfPixelsByNoise) {
  // Between pixels the right image is smoother: there its noise seems less.
  const Photometry light = {.contrast = 12, .mean = 110, .noise = 3.0};
  for (const double fraction : {0.25, 0.75}) {
    const SlantedPlane plane{20.0 + fraction, 0.0, 0.0};
    const StereoFrame frame = RenderPlane(640, 200, plane, light);
    cv::Mat1f disparity(200, 640, static_cast<float>(plane.At(0, 0))), sigma;
    Refiner({.iterations = 3}).Refine(frame.left, frame.right, disparity, &sigma);
    double sum = 0.0;
    int count = 0;
    for (int v = 3; v < 197; ++v)
      for (int u = 30; u < 637; ++u) sum += disparity(v, u) - plane.At(u, v), ++count;
    const double towards_half = fraction < 0.5 ? sum / count : -sum / count;
    EXPECT_LT(towards_half, 0.02);  // 0.07 if both images' gradients counted the same
  }
}

TEST(RefinementTest, RefinesTheGreatestDisparities) {
  const SlantedPlane plane{254.3, 0.0, 0.0};
  const StereoFrame frame = RenderPlane(400, 40, plane);
  cv::Mat1f disparity = RoughDisparity(400, 40, plane, 0.3), sigma;
  Refiner({}).Refine(frame.left, frame.right, disparity, &sigma);
  std::vector<float> found;
  for (int v = 5; v < 35; ++v)
    for (int u = 260; u < 395; ++u)
      if (!std::isnan(disparity(v, u))) found.push_back(disparity(v, u));
  std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
  EXPECT_NEAR(found[found.size() / 2], 254.3, 0.02);
}

TEST(RefinementTest, GivesTheSameBitsOnEveryTarget) {
  const SlantedPlane plane{6.2, 0.02, 0.3};
  const StereoFrame frame = RenderPlane(101, 37, plane);
  cv::Mat1f rough = RoughDisparity(101, 37, plane, 0.5);
  for (int v = 10; v < 20; ++v)
    for (int u = 50; u < 60; ++u) rough(v, u) += 7.0f;  // another surface
  for (int v = 20; v < 37; ++v)
    for (int u = 0; u < 101; ++u) rough(v, u) += 0.8f * static_cast<float>(v - 20);  // steep
  SteepSurfaces steep;
  steep.Measure(rough);
  std::vector<cv::Mat1f> disparities, sigmas;
  OnEveryTarget([&] {
    cv::Mat1f disparity = rough.clone(), sigma;
    Refiner({}).Refine(frame.left, frame.right, disparity, &sigma, {&steep, 1});
    disparities.push_back(disparity), sigmas.push_back(sigma);
  });
  for (std::size_t i = 1; i < disparities.size(); ++i) {
    EXPECT_TRUE(SameBits(disparities[0], disparities[i])) << i;
    EXPECT_TRUE(SameBits(sigmas[0], sigmas[i])) << i;
  }
}

TEST(RefinementTest, DoesNotMixTwoSurfaces) {
  // A texture at 5 px stands before one at 12 px; the window at the border takes its own side only.
  const StereoFrame far_frame = RenderPlane(120, 40, {5.0, 0, 0}, {}, 1);
  const StereoFrame near_frame = RenderPlane(120, 40, {12.0, 0, 0}, {}, 2);
  StereoFrame frame = far_frame;
  cv::Mat1f disparity(40, 120, 5.0f), sigma;
  for (int v = 0; v < 40; ++v)
    for (int u = 60; u < 120; ++u) {
      frame.left(v, u) = near_frame.left(v, u);
      if (u - 12 < 108) frame.right(v, u - 12) = near_frame.right(v, u - 12);
      disparity(v, u) = 12.3f;
    }
  // The first column, whose neighbour is another surface, holds on however often it is refined.
  Refiner({.iterations = 6}).Refine(frame.left, frame.right, disparity, &sigma);
  for (int u = 60; u < 63; ++u) {
    double squares = 0.0;
    for (int v = 5; v < 35; ++v) squares += std::pow(disparity(v, u) - 12.0, 2);
    EXPECT_LT(std::sqrt(squares / 30), 0.12) << "column " << u;
  }
}

}  // namespace
}  // namespace terrace
