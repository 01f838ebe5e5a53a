// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "evaluation/disparity_truth.h"

namespace terrace {

/// What one or many disparity images have in common with the truth. Counts and sums, so that images add up.
class DisparityErrors {
 public:
  /// Throws FileError when the sizes differ.
  void Add(const FloatImage& disparity_px, const DisparityTruth& truth);

  std::int64_t num_visible() const { return num_visible_; }
  std::int64_t num_valid() const { return num_valid_; }
  std::int64_t num_hidden() const { return num_hidden_; }
  double density_pct() const;  ///< of the visible pixels, those with a value
  /// Of the visible pixels with a value, those more than `bad_px` (0.5, 1, 2) off.
  double bad_valid_pct(double bad_px) const;
  /// Of all visible pixels, those without a value or more than `bad_px` off.
  double bad_all_pct(double bad_px) const;
  double d1_valid_pct() const;  ///< more than 3 px and 5 % off
  double d1_all_pct() const;
  double average_px() const;  ///< |error| of visible pixels with a value
  double rms_px() const;
  double invented_pct() const;  ///< of the pixels that are hidden in the right image, those with a value
  /// Greatest |mean error| over bins of the true fractional disparity, of values within 1 px of the truth;
  /// bins of fewer than 100 values are left out.
  double lock_px() const;
  double bias_px() const;  ///< mean of the same errors

 private:
  static constexpr std::array<double, 3> kBad_px = {0.5, 1.0, 2.0};
  static constexpr int kNumBins = 20;

  double Share(std::int64_t count, std::int64_t of) const;
  std::int64_t NumBad(double bad_px) const;

  std::int64_t num_visible_ = 0;
  std::int64_t num_valid_ = 0;
  std::int64_t num_hidden_ = 0;
  std::int64_t num_invented_ = 0;
  std::array<std::int64_t, kBad_px.size()> num_bad_{};
  std::int64_t num_d1_ = 0;
  double sum_absolute_ = 0.0;
  double sum_square_ = 0.0;
  std::array<std::int64_t, kNumBins> bin_counts_{};
  std::array<double, kNumBins> bin_sums_{};
};

/// One true plane fitted in one disparity image.
struct PlaneFit {
  int polygon_id = 0;
  std::string label;
  double depth_m = 0.0;  ///< of the middle of the mask
  int num_pixels = 0;
  double offset_px = 0.0;  ///< fitted less true disparity there
  double offset_mm = 0.0;  ///< distance of the fitted point there from the true plane, positive when nearer
  double angle_deg = 0.0;  ///< between the normals
};

/// One place where a true edge with a step in depth crosses a row or a column of the image.
struct EdgeFit {
  double distance_px = 0.0;  ///< of the fitted step from the projected edge
  double depth_m = 0.0;      ///< of the near side
};

/// Robust planes in disparity space inside the mask of each true polygon, eroded by 3 px; masks of fewer than
/// 400 pixels with a value are left out.
std::vector<PlaneFit> FitPlanes(const FloatImage& disparity_px, const RenderedTruth& truth,
                                const TrueScene& scene, const StereoCamera& camera,
                                const Eigen::Isometry3d& T_world_left);

/// Where the disparity image steps, beside every projected edge of a true polygon that hides something at
/// least 2 px of disparity behind it.
std::vector<EdgeFit> FitEdges(const FloatImage& disparity_px, const RenderedTruth& truth,
                              const TrueScene& scene, const StereoCamera& camera,
                              const Eigen::Isometry3d& T_world_left);

/// Medians of plane figures.
struct PlaneFigures {
  int count = 0;
  double offset_px = 0.0;  ///< median of the absolute values, as are the next two
  double offset_mm = 0.0;
  double angle_deg = 0.0;
};

/// One image of many, to be looked at.
struct DisparityExample {
  Timestamp t_capture;
  double bad1_all_pct = 0.0;
  GrayImage picture;  ///< PictureOfErrors()
};

struct DisparityEvaluation {
  int num_images = 0;
  DisparityErrors errors;
  std::vector<PlaneFit> planes;
  std::vector<EdgeFit> edges;
  std::optional<DisparityExample> best, worst;  ///< by bad1_all_pct

  double edge_median_px() const;
  /// Of the planes with one of these labels not farther than `max_depth_m`; no label means every one.
  PlaneFigures Planes(const std::vector<std::string>& labels, double max_depth_m) const;
};

}  // namespace terrace
