// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "stereo/disparity_image.h"
#include "stereo/disparity_prior.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Settings of the disparity matcher. YAML section: `stereo`.
struct DisparityConfig {
  /// Search range; the nearest visible depth is focal_px * baseline_m / this. A multiple of 16, at most 512; or
  /// auto: as far as `nearest_m` needs, at most 256. Beyond that the images are matched at half their size,
  /// where fine detail is lost and repeated patterns deceive sooner.
  std::optional<int> max_disparity_px = 128;
  /// With `max_disparity_px: auto`, the nearest distance at which something matters.
  double nearest_m = 0.4;
  /// "fast": matched at half resolution, refined at full. "quality": matched again at full resolution, near
  /// what was found at half; three times the work, for finer detail.
  std::string tier = "fast";
  /// What is compared: "mixed" (keeps the edges of objects best), "5x5" (finest detail), "9x7" (steadiest in
  /// noise and darkness) or "auto" (mixed at half resolution, 9x7 at full).
  std::string census = "auto";
  /// Along how many paths costs are summed into each pixel, in every match of a tier: 4, the straight ones;
  /// 8, with the diagonals, which costs more and is right as often; or 2, those within the row, which costs
  /// less.
  int paths = 4;
  /// Penalty for a change of disparity by one between neighbours, in census bits (of 32).
  int small_step_penalty = 8;
  /// Penalty for a greater change where the image is flat; at most 50.
  int large_step_penalty = 50;
  /// The same where the brightness jumps too, as it does at the edge of an object.
  int edge_step_penalty = 10;
  /// How many percent more than the best any other disparity must cost.
  int uniqueness_percent = 0;
  /// Left-right agreement a pixel needs to be kept.
  double max_left_right_error_px = 1.0;
  /// Connected pieces smaller than this are thrown away.
  int min_piece_px = 100;
  /// Measure in every pair by how many rows the right image is off, as it is when the rig is not calibrated
  /// exactly, and take it out before matching.
  bool straighten_rows = true;
  /// Region of interest: the rectangle of the rectified left image that is matched; the rest stays unknown,
  /// and costs nothing but the columns on the left that the right image needs. What lies outside of the image
  /// does not count.
  int roi_left_px = 0;
  /// Its first row.
  int roi_top_px = 0;
  /// Its width; 0: as far as the image goes.
  int roi_width_px = 0;
  /// Its height; 0: as far as the image goes.
  int roi_height_px = 0;
  /// Search each strip of rows first where an earlier frame, moved to the present, says that something is,
  /// and from end to end only where that is not found, or in turn. Off, since the search is less than a third
  /// of the work: it saves nothing that can be measured.
  bool use_prior = false;
  /// How far from there is searched as well.
  int prior_margin_px = 4;
  /// Each strip is searched from end to end at least once in so many frames.
  int prior_full_every_frames = 16;

  /// The same, with the search range that `auto` stands for with this camera (rectified).
  DisparityConfig ForCamera(const StereoCamera& camera) const;
  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Dense stereo. Same input, same output, for any number of threads and on every processor.
class DisparityMatcher {
 public:
  /// Throws std::invalid_argument with every problem of the settings.
  /// @throws std::invalid_argument when the settings have problems, or the search range is still `auto`
  explicit DisparityMatcher(const DisparityConfig& config);
  ~DisparityMatcher();

  /// @param prior  what is known before; null: nothing, as where the settings do not use it
  DisparityImage Match(const StereoFrame& frame, const DisparityPrior* prior = nullptr);

 private:
  class Impl;  // holds the buffers, so that a frame allocates nothing but its result
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
