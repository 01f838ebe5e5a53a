// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "stereo/disparity_image.h"
#include "stereo/row_offsets.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// What one frame says of the health of a pair of cameras.
struct PairHealth {
  /// Shares of the image in which nothing is to be seen: white, black, or without any change of brightness.
  float left_blank_share = 0.0f, right_blank_share = 0.0f;
  /// Mean brightness of the right image against the left one's.
  float brightness_ratio = 1.0f;
  /// How many frames in a row have shown bit by bit what the one before showed. Cameras never do while they
  /// work, as their noise changes; recordings of one pair that is repeated do.
  int num_same_left = 0, num_same_right = 0;
  /// By how many rows the right image is off. `num_places` is 0 where the two have too little in common to
  /// tell.
  RowOffsets row_offsets;
  /// By how much disparities are wrong, root mean square over the image, by the roll and the size of the
  /// right camera that its rows show.
  float disparity_error_px = 0.0f;
  /// Those with a disparity, of all pixels or of those around which the left image shows something, whichever
  /// is more.
  float known_share = 0.0f;
  /// As in DisparityImage.
  float no_match_share = 0.0f, limit_share = 0.0f;

  bool left_blank = false, right_blank = false;  ///< nearly all of it
  bool half_blank = false;                       ///< much more of the one image than of the other
  bool different = false;                        ///< both show something, but not the same
  bool left_stands = false;   ///< the same images again and again, while the other camera goes on
  bool right_stands = false;  ///< likewise
  bool both_stand = false;    ///< both cameras, for long; recordings of one pair do so, too
  bool rows_off = false;      ///< so much that the rig should be calibrated again
  bool warped = false;        ///< the right camera is rolled or of another size: disparities are wrong, too
  bool not_at_once = false;   ///< rows that come and go: the two images are not of one moment

  /// Nothing that this frame shows should enter the map.
  bool stops_mapping() const {
    return left_blank || right_blank || half_blank || different || left_stands || right_stands || warped ||
           not_at_once;
  }
  /// What is found in both images, too, lies where nothing is: distances, and with them poses, are wrong.
  bool misplaces() const { return different || warped || not_at_once; }
  /// The gravest finding in a sentence, with what to do; empty when there is none.
  std::string Reason() const;
};

/// A finding that stays for a while once it has been made twice: what is wrong with a rig is not seen in
/// every image, and does not go away in between.
class LastingFinding {
 public:
  /// @param seen  in this frame; none: this frame does not say
  bool Update(std::optional<bool> seen);

 private:
  int num_left_ = 0;  ///< frames without it until it is over
  bool seen_before_ = false;
};

/// Looks at every pair whether its two images can be what a pair of cameras sees. Cheap: of the images it
/// looks at every eighth row, the rest the matcher has found anyway.
class PairMonitor {
 public:
  /// @param disparity  of that frame
  PairHealth Check(const StereoFrame& frame, const DisparityImage& disparity);

 private:
  void CheckRows(const cv::Size& size, PairHealth* health);

  /// Of the frame before; 0: there was none.
  std::uint64_t left_fingerprint_ = 0, right_fingerprint_ = 0;
  int num_same_left_ = 0, num_same_right_ = 0;
  std::optional<float> rows_before_px_;  ///< offset in the middle, of the last frame that said
  LastingFinding different_, warped_, not_at_once_;
  float disparity_error_px_ = 0.0f;  ///< of the last frame that said
};

}  // namespace terrace
