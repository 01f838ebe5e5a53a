// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/pair_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/check.h"
#include "stereo/image_fingerprint.h"

namespace terrace {
namespace {

constexpr int kRowStep = 8;      // of the rows that are looked at
constexpr int kPieceWidth = 32;  // of a row
constexpr int kDisparityStep = 8;

constexpr int kWhite = 251;
/// Mean and most of a piece that shows nothing but the noise of the dark.
constexpr int kDarkMean = 6, kDarkMost = 14;
/// Grey levels between the darkest and the brightest pixel of a piece that shows nothing. Sensors' noise is
/// more where there is any light.
constexpr int kFlat = 2;

constexpr float kAllBlank = 0.9f;
constexpr float kMuchMoreBlank = 0.25f;
constexpr float kSomethingToSee = 0.7f;  // less blank than this
/// Two images of different things have disparities on less than this, a pair on more.
constexpr float kDifferentKnown = 0.5f;
/// Grey values that differ by this, so far to both sides of a pixel, are more than noise.
constexpr int kTexture = 10, kTextureReach = 6;
constexpr float kEnoughTexture = 0.05f;  // of the pixels
constexpr float kRowsOff_px = 0.7f;
/// Radians of roll, and share of the size: a quarter of a degree or four thousandths. Real rigs that were
/// calibrated with care leave over half as much, measured.
constexpr float kWarped = 0.004f;
/// From one frame to the next; calibrations do not change.
constexpr float kRowsChange_px = 1.0f;
constexpr float kMuchBrighter = 1.5f;

/// What the rows of one image say that are looked at.
struct Glance {
  float blank_share = 0.0f;
  float mean = 0.0f;
  std::uint64_t fingerprint = 0;
};

Glance LookAt(const cv::Mat1b& image) {
  Glance glance;
  std::int64_t sum = 0;
  int num_pieces = 0, num_blank = 0, num_pixels = 0;
  for (int v = kRowStep / 2; v < image.rows; v += kRowStep) {
    const std::uint8_t* row = image[v];
    for (int begin = 0; begin < image.cols; begin += kPieceWidth) {
      const int end = std::min(begin + kPieceWidth, image.cols);
      int least = 255, most = 0, piece_sum = 0;
      for (int u = begin; u < end; ++u) {
        const int grey = row[u];
        least = std::min(least, grey), most = std::max(most, grey);
        piece_sum += grey;
      }
      sum += piece_sum, num_pixels += end - begin;
      ++num_pieces;
      const bool dark = most <= kDarkMost && piece_sum <= kDarkMean * (end - begin);
      num_blank += most - least <= kFlat || dark || least >= kWhite;
    }
  }
  glance.blank_share = static_cast<float>(num_blank) / static_cast<float>(std::max(num_pieces, 1));
  glance.mean = static_cast<float>(sum) / static_cast<float>(std::max(num_pixels, 1));
  glance.fingerprint = ImageFingerprint(image);
  return glance;
}

/// Counts on when the fingerprint is that of the frame before.
int Repeated(std::uint64_t fingerprint, std::uint64_t& before, int num_same) {
  const bool same = fingerprint == before;
  before = fingerprint;
  return same ? num_same + 1 : 0;
}

/// Whether there is something to match: more than the noise of a clear sky.
bool ShowsSomething(const cv::Mat1b& image, int row, int column) {
  const std::uint8_t* pixel = image[row];
  const int begin = std::max(column - kTextureReach, 0),
            end = std::min(column + kTextureReach + 1, image.cols);
  const auto [least, most] = std::minmax_element(pixel + begin, pixel + end);
  return *most - *least >= kTexture;
}

/// Of all pixels or of those around which the left image shows something, whichever is more.
float KnownShare(const cv::Mat1b& left, const cv::Mat1f& disparity) {
  int num = 0, num_known = 0, num_textured = 0, num_textured_known = 0;
  for (int v = kDisparityStep / 2; v < disparity.rows; v += kDisparityStep)
    for (int u = kDisparityStep / 2; u < disparity.cols; u += kDisparityStep) {
      const bool known = !std::isnan(disparity(v, u)), textured = ShowsSomething(left, v, u);
      ++num;
      num_known += known;
      num_textured += textured;
      num_textured_known += known && textured;
    }
  const float of_all = static_cast<float>(num_known) / static_cast<float>(std::max(num, 1));
  if (num_textured < kEnoughTexture * num) return of_all;
  return std::max(of_all,
                  static_cast<float>(num_textured_known) / static_cast<float>(std::max(num_textured, 1)));
}

std::string Sentence(const char* format, double value) {
  char text[256];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string Different(float brightness_ratio) {
  const std::string what =
      "the two images do not show the same: not of one moment, swapped, not rectified, or one of another "
      "camera";
  if (brightness_ratio > kMuchBrighter)
    return what + Sentence("; the right one is %.1f times as bright: look at its exposure", brightness_ratio);
  if (brightness_ratio < 1.0f / kMuchBrighter)
    return what +
           Sentence("; the left one is %.1f times as bright: look at its exposure", 1 / brightness_ratio);
  return what;
}

}  // namespace

bool LastingFinding::Update(std::optional<bool> seen) {
  constexpr int kLasts = 15;  // frames
  if (!seen) return num_left_ > 0;
  const bool again = *seen && (seen_before_ || num_left_ > 0);
  num_left_ = again ? kLasts : std::max(num_left_ - 1, 0);
  seen_before_ = *seen;
  return *seen || num_left_ > 0;
}

std::string PairHealth::Reason() const {
  if (left_blank && right_blank) return "both images are blank: no light, or the lenses are covered";
  if (left_blank)
    return "the left image is blank: its lens is covered, or its exposure or its cable is wrong";
  if (right_blank)
    return "the right image is blank: its lens is covered, or its exposure or its cable is wrong";
  if (half_blank) {
    const bool right = right_blank_share > left_blank_share;
    return Sentence(right ? "%.0f %% more of the right image than of the left one is blank: something covers "
                            "it, it is far too bright, or it is transferred in part"
                          : "%.0f %% more of the left image than of the right one is blank: something covers "
                            "it, it is far too bright, or it is transferred in part",
                    100.0 * std::abs(right_blank_share - left_blank_share));
  }
  if (left_stands) return "the left camera gives the same image again and again: it is frozen";
  if (right_stands) return "the right camera gives the same image again and again: it is frozen";
  if (not_at_once)
    return "the rows of the right image come and go: the two images are not of one moment, one camera is "
           "late";
  if (different) return Different(brightness_ratio);
  if (warped)
    return Sentence(
        "the right image is rolled or of another size by what its rows show, which makes disparities wrong "
        "by "
        "%.1f px: calibrate the pair again",
        disparity_error_px);
  if (rows_off)
    return Sentence("the rows of the right image are off by %.1f px: calibrate the pair again",
                    std::abs(row_offsets.centre_px));
  if (both_stand)
    return "both cameras give the same images again and again: they are frozen, or it is a recording of one "
           "pair";
  return "";
}

PairHealth PairMonitor::Check(const StereoFrame& frame, const DisparityImage& disparity) {
  TERRACE_CHECK(disparity.disparity_px.size() == frame.left.size(), disparity.disparity_px.cols,
                frame.left.cols);
  const Glance left = LookAt(frame.left), right = LookAt(frame.right);
  num_same_left_ = Repeated(left.fingerprint, left_fingerprint_, num_same_left_);
  num_same_right_ = Repeated(right.fingerprint, right_fingerprint_, num_same_right_);

  PairHealth health;
  health.left_blank_share = left.blank_share;
  health.right_blank_share = right.blank_share;
  health.brightness_ratio = std::max(right.mean, 1.0f) / std::max(left.mean, 1.0f);
  health.num_same_left = num_same_left_;
  health.num_same_right = num_same_right_;
  health.row_offsets = disparity.row_offsets;
  health.known_share = KnownShare(frame.left, disparity.disparity_px);
  health.no_match_share = disparity.no_match_share;
  health.limit_share = disparity.limit_share;

  health.left_blank = left.blank_share > kAllBlank;
  health.right_blank = right.blank_share > kAllBlank;
  health.half_blank = std::abs(left.blank_share - right.blank_share) > kMuchMoreBlank;
  const bool both_show = std::max(left.blank_share, right.blank_share) < kSomethingToSee;
  const bool different =
      both_show && health.row_offsets.num_places == 0 && health.known_share < kDifferentKnown;
  health.different = different_.Update(different);
  constexpr int kStands = 1, kStandsLong = 10;  // frames
  // A blank image is the same again and again, too, and that it is blank says more.
  const bool any_blank = health.left_blank || health.right_blank;
  health.left_stands = num_same_left_ >= kStands && num_same_right_ == 0 && !any_blank;
  health.right_stands = num_same_right_ >= kStands && num_same_left_ == 0 && !any_blank;
  health.both_stand = std::min(num_same_left_, num_same_right_) >= kStandsLong && !any_blank;
  CheckRows(frame.left.size(), &health);
  return health;
}

void PairMonitor::CheckRows(const cv::Size& size, PairHealth* health) {
  const RowOffsets& rows = health->row_offsets;
  if (rows.num_places == 0) {
    health->warped = warped_.Update(std::nullopt);
    health->not_at_once = not_at_once_.Update(std::nullopt);
    health->disparity_error_px = disparity_error_px_;
    return;
  }
  // A roll by a moves a pixel by (-a y, a x), another size by s (x, y): the rows show both.
  const float of_roll = rows.per_column * static_cast<float>(size.height),
              of_size = rows.per_row * static_cast<float>(size.width);
  disparity_error_px_ = std::sqrt((of_roll * of_roll + of_size * of_size) / 12.0f);
  health->disparity_error_px = disparity_error_px_;
  const bool changed = rows_before_px_ && std::abs(rows.centre_px - *rows_before_px_) > kRowsChange_px;
  rows_before_px_ = rows.centre_px;
  health->not_at_once = not_at_once_.Update(changed);
  health->warped = warped_.Update(std::hypot(rows.per_column, rows.per_row) > kWarped);
  health->rows_off = rows.Rms(size) > kRowsOff_px;
}

}  // namespace terrace
