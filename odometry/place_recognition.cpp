// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/place_recognition.h"

#include <algorithm>
#include <array>
#include <bit>
#include <random>

#include "odometry/feature_finder.h"

namespace terrace {
namespace {

constexpr int kReach = 11;  // px of the level described

struct Comparison {
  int u1, v1, u2, v2;
};

/// The same pairs in every program: denser near the middle.
const std::array<Comparison, 256>& Pattern() {
  static const std::array<Comparison, 256> pattern = [] {
    std::mt19937 random(42);
    const auto Offset = [&random] {
      return static_cast<int>(random() % (kReach + 1)) + static_cast<int>(random() % (kReach + 1)) - kReach;
    };
    std::array<Comparison, 256> pairs{};
    for (Comparison& pair : pairs) {
      // One after the other: the order of evaluation of arguments is the compiler's.
      pair.u1 = Offset();
      pair.v1 = Offset();
      pair.u2 = Offset();
      pair.v2 = Offset();
    }
    return pairs;
  }();
  return pattern;
}

}  // namespace

std::optional<Descriptor> Describe(const ImagePyramid& image, const Eigen::Vector2d& pixel) {
  constexpr int kLevel = 1;  // smoothed, so that single pixels do not decide
  const cv::Mat1b& level = image[kLevel];
  const int u = static_cast<int>(pixel.x()) >> kLevel;
  const int v = static_cast<int>(pixel.y()) >> kLevel;
  if (u < kReach || v < kReach || u + kReach >= level.cols || v + kReach >= level.rows) return std::nullopt;
  Descriptor descriptor{};
  for (std::size_t i = 0; i < Pattern().size(); ++i) {
    const Comparison& pair = Pattern()[i];
    const bool brighter = level(v + pair.v1, u + pair.u1) > level(v + pair.v2, u + pair.u2);
    descriptor[i / 64] |= static_cast<std::uint64_t>(brighter) << (i % 64);
  }
  return descriptor;
}

int Distance(const Descriptor& a, const Descriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) distance += std::popcount(a[i] ^ b[i]);
  return distance;
}

std::vector<DescribedFeature> DescribeAll(const ImagePyramid& left, const std::vector<Landmark>& landmarks) {
  std::vector<DescribedFeature> features;
  for (const Landmark& landmark : landmarks) {
    const auto descriptor = Describe(left, landmark.pixel_host);
    if (!descriptor) continue;
    features.emplace_back().descriptor = *descriptor;
    features.back().uvd << landmark.pixel_host, landmark.disparity_host_px;
  }
  return features;
}

std::vector<DescribedFeature> DescribeFrame(const StereoFrame& frame, const StereoCamera& camera,
                                            double vertical_px) {
  constexpr int kNumCells = 400;
  constexpr int kMaxDisparity_px = 192;
  constexpr double kMinDisparity_px = 2.0;
  const FeatureGrid grid = FeatureGrid::For(camera.width, camera.height, kNumCells);
  const FeatureFinder finder(camera, grid, kMaxDisparity_px);
  const std::vector<bool> nothing(static_cast<std::size_t>(grid.num_cells()), false);
  const ImagePyramid left = BuildPyramid(frame.left);
  std::vector<DescribedFeature> features =
      DescribeAll(left, finder.Find(left, BuildPyramid(frame.right), nothing, vertical_px));
  std::erase_if(features, [](const DescribedFeature& feature) { return feature.uvd.z() < kMinDisparity_px; });
  return features;
}

std::optional<PoseSolution> Recognize(const std::vector<DescribedFeature>& features,
                                      const std::vector<PlaceCorner>& corners,
                                      const Eigen::Isometry3d& T_world_host, const StereoCamera& camera,
                                      std::uint32_t seed) {
  constexpr int kMaxDistance = 64;
  constexpr double kMaxRatio = 0.8;  // of the best to the second best
  constexpr double kSigmaPx = 1.5;   // corners are found to a pixel or two
  constexpr int kMinInliers = 15;
  constexpr double kMinInlierShare = 0.4;

  std::vector<PoseConstraint> constraints;
  for (const DescribedFeature& feature : features) {
    int nearest = 257, second = 257;
    const PlaceCorner* match = nullptr;
    for (const PlaceCorner& corner : corners) {
      const int distance = Distance(feature.descriptor, corner.descriptor);
      if (distance < nearest) {
        second = nearest;
        nearest = distance;
        match = &corner;
      } else {
        second = std::min(second, distance);
      }
    }
    if (nearest > kMaxDistance || nearest > kMaxRatio * second) continue;
    PoseConstraint c;
    c.point_world = T_world_host * match->p_left;
    c.inverse_depth = 1.0;
    c.uvd = feature.uvd;
    c.whitening /= kSigmaPx;
    constraints.push_back(c);
  }
  PosePrior vague;
  vague.T_world_left = T_world_host;
  vague.information.diagonal().setConstant(1.0);
  PoseSolution solution = SolvePose(constraints, vague, camera, seed);
  if (solution.num_inliers < kMinInliers ||
      solution.num_inliers < kMinInlierShare * static_cast<double>(constraints.size()))
    return std::nullopt;
  return solution;
}

}  // namespace terrace
