// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "evaluation/disparity_file.h"
#include "results/replay_result.h"

namespace terrace {

/// How well saved disparities agree with the images and with each other, where nothing true is known.
struct DisparityConsistency {
  int num_images = 0;
  double density_pct = 0.0;  ///< pixels with a value, of all
  std::int64_t num_photometric = 0;
  double photometric_median = 0.0;  ///< grey values between left image and warped right one, gain evened out
  double photometric_p90 = 0.0;
  std::int64_t num_temporal = 0;
  double temporal_median_px =
      0.0;                        ///< between what one image predicts by the poses and what the next one says
  double temporal_off_pct = 0.0;  ///< of these, more than a pixel
};

/// Collects the figures image by image.
class ConsistencyMeter {
 public:
  explicit ConsistencyMeter(const StereoCamera& camera) : camera_(camera) {}

  /// @param pair  rectified, of the same moment; null: not known
  /// @param T_world_left  where the camera was; none: not tracked, so that nothing is compared over time
  void Add(const FloatImage& disparity_px, const StereoPair* pair,
           const std::optional<Eigen::Isometry3d>& T_world_left);
  DisparityConsistency Result() const;

 private:
  void AddPhotometric(const FloatImage& disparity_px, const StereoPair& pair);
  void AddTemporal(const FloatImage& disparity_px, const Eigen::Isometry3d& T_world_left);

  StereoCamera camera_;
  int num_images_ = 0;
  std::int64_t num_pixels_ = 0;
  std::int64_t num_values_ = 0;
  std::vector<double> grey_;
  std::vector<double> moved_px_;
  FloatImage last_px_;
  std::optional<Eigen::Isometry3d> T_world_last_;
};

/// Of the disparity images that a replay saved; none when it saved none. The images of the sequence are used
/// when they are rectified as they are. Throws FileError and SequenceError.
std::optional<DisparityConsistency> EvaluateConsistency(const ReplayResult& result,
                                                        const std::filesystem::path& sequence);

}  // namespace terrace
