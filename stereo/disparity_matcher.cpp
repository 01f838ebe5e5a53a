// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include <opencv2/core.hpp>

#include "core/check.h"
#include "core/field_problems.h"
#include "stereo/depth_edges.h"
#include "stereo/disparity_filters.h"
#include "stereo/disparity_units.h"
#include "stereo/flat_fringes.h"
#include "stereo/half_resolution.h"
#include "stereo/refinement.h"
#include "stereo/repeated_patterns.h"
#include "stereo/row_offsets.h"
#include "stereo/semi_global.h"
#include "stereo/steep_surfaces.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

constexpr int kRangeStep = 16;  // of the settings
constexpr int kMostDisparity_px = 512;
constexpr int kMostAtFullSize_px = 256;  // what costs and whole numbers of disparities have room for

std::vector<CensusPair> CensusByName(const std::string& name) {
  if (name == "5x5") return Census5x5();
  if (name == "9x7") return Census9x7();
  return CensusMixed();
}

SemiGlobalSettings MatchingSettings(const DisparityConfig& config, const std::string& best_census) {
  SemiGlobalSettings settings;
  settings.census = CensusByName(config.census != "auto" ? config.census : best_census);
  settings.penalties = {config.small_step_penalty, config.large_step_penalty, config.edge_step_penalty};
  settings.num_paths = config.paths;
  settings.winner.uniqueness_percent = config.uniqueness_percent;
  settings.winner.max_left_right_error = static_cast<int>(std::lround(config.max_left_right_error_px));
  return settings;
}

/// Images that are used again when nobody else holds them any more: memory that is fresh for every frame
/// costs a tenth of the work in page faults.
class ImagePool {
 public:
  cv::Mat1f Take(const cv::Size& size) {
#ifdef __SANITIZE_THREAD__
    // OpenCV counts the holders in its own library, where the thread sanitizer does not see it.
    return cv::Mat1f(size);
#endif
    for (const cv::Mat1f& image : images_)
      if (image.size() == size && CV_XADD(&image.u->refcount, 0) == 1) return image;
    if (images_.size() == kMaxImages) images_.erase(images_.begin());
    return images_.emplace_back(size);
  }

 private:
  static constexpr std::size_t kMaxImages = 12;  // of frames that are under way
  std::vector<cv::Mat1f> images_;
};

/// Gives each unknown pixel a rough disparity: the lesser of those that end its gap in the row, as the
/// further surface is the one that is hidden; that of the row above where the whole row is unknown.
void FillFromFurther(cv::Mat1f& disparity) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  for (int v = 0; v < disparity.rows; ++v) {
    float* row = disparity[v];
    for (int u = 0; u < disparity.cols; ++u) {
      if (!std::isnan(row[u])) continue;
      int end = u;
      while (end < disparity.cols && std::isnan(row[end])) ++end;
      float rough = std::min(u > 0 ? row[u - 1] : kNone, end < disparity.cols ? row[end] : kNone);
      if (rough == kNone) rough = v > 0 ? disparity(v - 1, 0) : 0.0f;
      std::fill(row + u, row + end, rough);
      u = end;
    }
  }
}

/// The same settings for images of half the size.
DisparityConfig OfHalves(const DisparityConfig& config) {
  DisparityConfig halves = config;
  const int half_range = (*config.max_disparity_px + 1) / 2;
  halves.max_disparity_px = (half_range + kRangeStep - 1) / kRangeStep * kRangeStep;
  halves.use_prior = false;  // a prior's tiles are those of the whole images
  return halves;
}

}  // namespace

std::vector<std::string> DisparityConfig::Problems() const {
  FieldProblems problems;
  const int range = max_disparity_px.value_or(kMostAtFullSize_px);
  problems.Require(range >= 16 && range <= kMostDisparity_px && range % kRangeStep == 0, "max_disparity_px",
                   range, "be auto or a multiple of 16 from 16 to 512");
  problems.RequireAbove("nearest_m", nearest_m, 0.0);
  problems.Require(tier == "fast" || tier == "quality", "tier", tier, "be fast or quality");
  problems.Require(census == "auto" || census == "mixed" || census == "5x5" || census == "9x7", "census",
                   census, "be auto, mixed, 5x5 or 9x7");
  problems.Require(paths == 2 || paths == 4 || paths == 8, "paths", paths, "be 2, 4 or 8");
  problems.RequireAtLeast("small_step_penalty", small_step_penalty, 0);
  problems.Require(edge_step_penalty >= small_step_penalty, "edge_step_penalty", edge_step_penalty,
                   "be at least small_step_penalty");
  problems.Require(large_step_penalty >= edge_step_penalty && large_step_penalty <= 50, "large_step_penalty",
                   large_step_penalty, "be at least edge_step_penalty, at most 50");
  problems.RequireWithin("uniqueness_percent", uniqueness_percent, 0, 100);
  problems.RequireAtLeast("max_left_right_error_px", max_left_right_error_px, 0.0);
  problems.RequireAtLeast("min_piece_px", min_piece_px, 0);
  problems.RequireAtLeast("roi_left_px", roi_left_px, 0);
  problems.RequireAtLeast("roi_top_px", roi_top_px, 0);
  problems.RequireAtLeast("roi_width_px", roi_width_px, 0);
  problems.RequireAtLeast("roi_height_px", roi_height_px, 0);
  problems.RequireWithin("prior_margin_px", prior_margin_px, 1, 256);
  problems.RequireAtLeast("prior_full_every_frames", prior_full_every_frames, 1);
  return problems.Take();
}

DisparityConfig DisparityConfig::ForCamera(const StereoCamera& camera) const {
  DisparityConfig resolved = *this;
  if (max_disparity_px) return resolved;
  const double needed_px = std::ceil(camera.fx * camera.baseline_m / nearest_m / kRangeStep) * kRangeStep;
  resolved.max_disparity_px = static_cast<int>(std::clamp<double>(needed_px, kRangeStep, kMostAtFullSize_px));
  return resolved;
}

class DisparityMatcher::Impl {
 public:
  explicit Impl(const DisparityConfig& config)
      : config_(config),
        range_px_(config.max_disparity_px.value()),
        half_matcher_(MatchingSettings(config, "mixed")),
        full_matcher_(MatchingSettings(config, "9x7")),
        edges_({.rounds = 1}),
        refiner_({.iterations = config.tier == "fast" ? 1 : 3}),
        half_refiner_({.iterations = config.tier == "fast" ? 3 : 2}) {
    if (range_px_ > kMostAtFullSize_px) of_halves_ = std::make_unique<Impl>(OfHalves(config));
  }

  DisparityImage Match(const StereoFrame& frame, const DisparityPrior* prior) {
    const cv::Rect image({0, 0}, frame.left.size());
    const cv::Rect region = RegionIn(image);
    return region == image ? MatchAll(frame, prior) : MatchRegion(frame, prior, region);
  }

 private:
  cv::Rect RegionIn(const cv::Rect& image) const {
    const int width = config_.roi_width_px > 0 ? config_.roi_width_px : image.width;
    const int height = config_.roi_height_px > 0 ? config_.roi_height_px : image.height;
    const int left = std::min(config_.roi_left_px, image.width),
              top = std::min(config_.roi_top_px, image.height);
    return {left, top, std::min(width, image.width - left), std::min(height, image.height - top)};
  }

  /// Matches a cut of the images that has all that the region needs around it.
  DisparityImage MatchRegion(const StereoFrame& frame, const DisparityPrior* prior, const cv::Rect& region) {
    constexpr int kTilePx = DisparityPrior::kTilePx;
    DisparityImage result{frame.frame_id, frame.t_capture, cv::Mat1f(frame.left.size(), kUnknownDisparity),
                          cv::Mat1f(frame.left.size(), kUnknownDisparity)};
    if (region.empty()) return result;
    // From whole tiles on, so that a prior can be cut, too.
    const int left = std::max(region.x - kAroundRegionPx - range_px_, 0) / kTilePx * kTilePx;
    const int top = std::max(region.y - kAroundRegionPx, 0) / kTilePx * kTilePx;
    const int right = std::min(region.br().x + kAroundRegionPx, frame.left.cols);
    const int bottom = std::min(region.br().y + kAroundRegionPx, frame.left.rows);
    const cv::Rect cut(left, top, right - left, bottom - top);
    StereoFrame part{frame.frame_id, frame.t_capture, frame.left(cut).clone(), frame.right(cut).clone()};
    std::optional<DisparityPrior> part_prior;
    if (prior) {
      part_prior.emplace(cut.width, cut.height);
      for (int row = 0; row < part_prior->rows; ++row)
        for (int column = 0; column < part_prior->columns; ++column)
          part_prior->At(row, column) = prior->At(row + top / kTilePx, column + left / kTilePx);
    }
    const DisparityImage found = MatchAll(part, part_prior ? &*part_prior : nullptr);
    const cv::Rect in_part = region - cut.tl();
    found.disparity_px(in_part).copyTo(result.disparity_px(region));
    found.sigma_px(in_part).copyTo(result.sigma_px(region));
    result.row_offsets = found.row_offsets;
    result.no_match_share = found.no_match_share;
    result.limit_share = found.limit_share;
    result.range_px = found.range_px;
    result.misalignment_px = found.misalignment_px;
    return result;
  }

  DisparityImage MatchAll(const StereoFrame& frame, const DisparityPrior* prior) {
    if (of_halves_) return MatchAtHalfSize(frame);
    const cv::Size size = frame.left.size();
    DisparityImage result{frame.frame_id, frame.t_capture, results_.Take(size), results_.Take(size)};
    result.row_offsets = Straighten(frame);
    if (config_.tier == "quality") {
      rough_disparity_.create(size);
      MatchHalved(frame, prior, rough_disparity_);
      MatchAgain(frame.left, right_, rough_disparity_, result.disparity_px);
    } else {
      MatchHalved(frame, prior, result.disparity_px);
    }
    result.no_match_share = static_cast<float>(half_matcher_.doubtful().share());
    result.limit_share = static_cast<float>(half_matcher_.doubtful().share_at_limit());
    result.range_px = static_cast<float>(range_px_);
    units_.Set(result.disparity_px);
    edges_.Sharpen(frame.left, right_, units_, {&steep_, 2});
    refiner_.Refine(frame.left, right_, units_, result.disparity_px, &result.sigma_px, {&steep_, 2});
    result.misalignment_px = MisalignmentOf(result.row_offsets, size);
    ForgetFlatFringes(frame.left, half_left_, result.disparity_px, result.sigma_px);
    ForgetBeyondRange(result);
    return result;
  }

  /// The halved images alone: what is so near that it needs such a range is as well known with half the
  /// pixels.
  DisparityImage MatchAtHalfSize(const StereoFrame& frame) {
    StereoFrame halves{frame.frame_id, frame.t_capture, {}, {}};
    HalveImage(frame.left, halves.left);
    HalveImage(frame.right, halves.right);
    DisparityImage found = of_halves_->MatchAll(halves, nullptr);
    const cv::Size size = frame.left.size();
    DisparityImage result{frame.frame_id, frame.t_capture, results_.Take(size), results_.Take(size)};
    steep_.Measure(found.disparity_px);
    DoubleDisparity(found.disparity_px, result.disparity_px, steep_);
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u) result.sigma_px(v, u) = 2.0f * found.sigma_px(v / 2, u / 2);
    result.row_offsets = found.row_offsets.Scaled(2.0f);
    result.no_match_share = found.no_match_share;
    result.limit_share = found.limit_share;
    result.range_px = static_cast<float>(range_px_);
    result.misalignment_px = 2.0f * found.misalignment_px;
    ForgetBeyondRange(result);
    return result;
  }

  /// More was searched than was asked for, so that what is just beyond is found there.
  void ForgetBeyondRange(DisparityImage& result) const {
    if (2 * HalfRange() <= range_px_) return;
    const cv::Mat beyond = result.disparity_px > static_cast<double>(range_px_);
    result.limit_share += static_cast<float>(cv::countNonZero(beyond)) / static_cast<float>(beyond.total());
    result.disparity_px.setTo(kUnknownDisparity, beyond);
    result.sigma_px.setTo(kUnknownDisparity, beyond);
  }

  /// What a prior says of the halved images.
  ExpectedDisparities Expect(const DisparityPrior* prior, const StereoFrame& frame,
                             int num_disparities) const {
    ExpectedDisparities expected;
    if (!prior || !config_.use_prior) return expected;
    expected.tile_px = DisparityPrior::kTilePx / 2;
    expected.columns = prior->columns;
    for (const DisparityPrior::Range& tile : prior->tiles) expected.known.push_back(tile.known());
    const int rows_per_strip = half_matcher_.rows_per_strip() / expected.tile_px;
    for (int top = 0; top < prior->rows; top += rows_per_strip) {
      const int bottom = std::min(top + rows_per_strip, prior->rows);
      // Neighbours have their turns far apart.
      const auto turn = static_cast<FrameId>(5 * expected.strips.size());
      const bool its_turn = (frame.frame_id + turn) % config_.prior_full_every_frames == 0;
      expected.strips.push_back(its_turn ? SearchRange{0, num_disparities}
                                         : RangeOf(*prior, top, bottom, num_disparities));
    }
    return expected;
  }

  /// All that is expected in rows [top, bottom) of tiles, and the margin.
  SearchRange RangeOf(const DisparityPrior& prior, int top, int bottom, int num_disparities) const {
    float low_px = std::numeric_limits<float>::infinity(), high_px = -low_px;
    for (int row = top; row < bottom; ++row)
      for (int column = 0; column < prior.columns; ++column) {
        const DisparityPrior::Range& tile = prior.At(row, column);
        if (!tile.known()) continue;
        low_px = std::min(low_px, tile.low_px);
        high_px = std::max(high_px, tile.high_px);
      }
    if (low_px > high_px) return {0, num_disparities};
    const auto scaled = [&](float d) {
      const double limit = num_disparities - 1;
      return static_cast<int>(std::clamp<double>(std::floor(d / 2), 0.0, limit));
    };
    const auto margin_px = static_cast<float>(config_.prior_margin_px);
    const int last = scaled(high_px + margin_px);
    // Vectors are full when the number of disparities is a multiple of 32.
    const int first = scaled(low_px - margin_px) / kRangeStep * kRangeStep;
    const int count = std::min((last - first + 32) / 32 * 32, num_disparities);
    return {std::min(first, (num_disparities - count) / kRangeStep * kRangeStep), count};
  }

  /// Full resolution, near what the halved images show.
  void MatchAgain(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& rough, cv::Mat1f& disparity) {
    FillFromFurther(rough);
    full_matcher_.MatchNear(left, right, rough, disparity);
    half_matcher_.doubtful().Forget(2, disparity);
    RemoveSpeckles(config_.min_piece_px, kMaxSlope, disparity, {&steep_, 2}, {&repeated_, 2});
  }

  /// The work of the first rounds costs a quarter at half the size, and sees twice as far.
  void MatchHalved(const StereoFrame& frame, const DisparityPrior* prior, cv::Mat1f& disparity) {
    const int range = HalfRange();
    half_matcher_.Match(half_left_, half_right_, range, half_disparity_, Expect(prior, frame, range));
    steep_.Measure(half_disparity_);
    repeated_.Find(half_left_);
    half_matcher_.doubtful().Forget(1, half_disparity_);
    // A quarter of the pixels, but noise holds together better.
    RemoveSpeckles(config_.min_piece_px / 2, kMaxSlope, half_disparity_, {&steep_, 1}, {&repeated_, 1});
    half_matcher_.doubtful().Recount(half_disparity_);
    half_refiner_.Refine(half_left_, half_right_, half_disparity_, nullptr, {&steep_, 1});
    DoubleDisparity(half_disparity_, disparity, steep_);
  }

  /// How far the columns are off nobody can see in one pair. A rig whose rows are off is as wrong along them,
  /// as far as that comes of its calibration: a camera that was pitched since then is not turned as well.
  static float MisalignmentOf(const RowOffsets& offsets, const cv::Size& size) {
    const float rows_px = offsets.Rms(size);
    const float square = rows_px * rows_px - kRowOffsetNoisePx * kRowOffsetNoisePx;
    return std::min(std::sqrt(std::max(square, 0.0f)), kMostMisalignmentPx);
  }

  /// The halved images, and the right one with rows where the left one has them.
  RowOffsets Straighten(const StereoFrame& frame) {
    HalveImage(frame.left, half_left_);
    HalveImage(frame.right, half_right_);
    right_ = frame.right;
    if (!config_.straighten_rows) return {};
    const RowOffsets offsets = MeasureRowOffsets(half_left_, half_right_, HalfRange()).Scaled(2.0f);
    if (offsets.Rms(right_.size()) < kMinRowOffsetPx) return offsets;
    StraightenRows(frame.right, offsets, straight_right_);
    right_ = straight_right_;
    HalveImage(right_, half_right_);
    return offsets;
  }

  /// Wide vectors take 64 disparities faster than 48.
  int HalfRange() const { return range_px_ <= 32 ? 16 : (range_px_ / 2 + 31) / 32 * 32; }

  static constexpr float kMinRowOffsetPx =
      0.07f;  // rms: what is less is hardly more than the error of measuring it
  static constexpr float kRowOffsetNoisePx = 0.05f;   // rms: what is measured where the rows are not off
  static constexpr float kMostMisalignmentPx = 0.2f;  // measured: calibrations leave no more
  static constexpr int kAroundRegionPx = 32;          // from which paths and windows reach into a region
  static constexpr float kMaxSlope = 1.0f;            // pixels of disparity between neighbours of one piece

  const DisparityConfig config_;
  const int range_px_;
  std::unique_ptr<Impl> of_halves_;  // where the range is too long for the whole images
  SemiGlobalMatcher half_matcher_, full_matcher_;
  DepthEdgeSharpener edges_;
  Refiner refiner_, half_refiner_;
  cv::Mat1b half_left_, half_right_, straight_right_;
  cv::Mat1b right_;  // as it is matched
  cv::Mat1f half_disparity_, rough_disparity_;
  SteepSurfaces steep_;
  RepeatedPatterns repeated_;
  UnitImage units_;
  ImagePool results_;
};

DisparityMatcher::DisparityMatcher(const DisparityConfig& config) {
  std::string all;
  for (const std::string& problem : config.Problems()) all += "stereo: " + problem + "\n";
  if (!config.max_disparity_px) all += "stereo: max_disparity_px is auto, and no camera was named\n";
  if (!all.empty()) throw std::invalid_argument(all);
  impl_ = std::make_unique<Impl>(config);
}
DisparityMatcher::~DisparityMatcher() = default;

DisparityImage DisparityMatcher::Match(const StereoFrame& frame, const DisparityPrior* prior) {
  TERRACE_CHECK(!frame.left.empty() && frame.left.size() == frame.right.size(), frame.left.cols,
                frame.left.rows, frame.right.cols, frame.right.rows);
  if (prior) {
    const DisparityPrior whole(frame.left.cols, frame.left.rows);
    TERRACE_CHECK(prior->rows == whole.rows && prior->columns == whole.columns, prior->rows, prior->columns);
  }
  return impl_->Match(frame, prior);
}

}  // namespace terrace
