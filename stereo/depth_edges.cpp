// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/depth_edges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <tbb/enumerable_thread_specific.h>

#include "core/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/depth_edges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_STEREO_DEPTH_EDGES_ONCE_
#define TERRACE_STEREO_DEPTH_EDGES_ONCE_
namespace terrace {

constexpr int kImageBorder = 8;  // pixels repeated left of the images
constexpr int kRowMargin = 16;   // unknown disparities before each row
constexpr int kBehind = 64;      // and behind it, as pixels behind those of the images: vectors touch them
constexpr int kHalfWindow = 4;   // of the windows' common width
constexpr int kWindowPixels = 15;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr float kClearlyBetter = 0.8f;  // of its own difference, to leave one's disparity for another
constexpr float kSamePlace = 0.5f;      // pixels between claims on the right image
/// Grey levels that a nearer surface must agree better by than a further one, to win a place: foregrounds
/// grow fat more often than they shrink.
constexpr int kNearerHandicap = 10;
/// Mean grey level difference with which a pixel right of an unknown one is not believed.
constexpr int kMaxDifferenceAtGap = 5;
constexpr int kMaxUnbelieved = 6;  // such pixels in a row

/// The two images of a pair with their edges repeated, the right one as bright as the left one.
struct EdgeImages {
  cv::Mat1b left, right;
  int width = 0;
  const std::uint8_t* Left(int u, int v) const { return left[v + 1] + kImageBorder + u; }
  const std::uint8_t* Right(int u, int v) const { return right[v + 1] + kImageBorder + u; }
};

/// A row of disparities and those at some reach above and below it, as they were given.
struct GivenRows {
  const float *row, *above, *below;
};

/// What the pixels of one row may take instead of their own disparity.
struct EdgeCandidates {
  struct Candidate {
    int u;
    float disparity;
  };
  std::vector<Candidate> candidates;
  std::vector<int> pixels;  // that have any
  std::vector<int> least;   // window difference of each pixel's best one
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Bytes16 = hn::FixedTag<std::uint8_t, 16>;
using VecB = hn::Vec<Bytes16>;

/// Sum of absolute differences between windows of 5x3 pixels that end or begin at the pixel, whichever agree
/// better: one of them lies on the pixel's own side of a depth edge. The right image is taken at quarters of
/// a pixel.
class WindowDifference {
 public:
  HWY_INLINE WindowDifference(const EdgeImages& images, int u, int v) : images_(images), u_(u), v_(v) {
    for (int row = 0; row < 3; ++row)
      left_[row] = Windows(hn::LoadU(Bytes16(), images.Left(u - kHalfWindow, v + row - 1)));
  }
  /// @param disparity  that leads to a place in the right image
  HWY_INLINE int At(float disparity) const {
    const Bytes16 d;
    const int quarters = static_cast<int>(4.0f * (static_cast<float>(u_) - disparity) + 0.5f);
    const std::uint8_t* right = images_.Right(quarters / 4 - kHalfWindow, v_ - 1);
    const std::size_t stride = images_.right.step;
    // Without branches, as fractions change from pixel to pixel.
    const auto odd = hn::MaskFromVec(hn::Set(d, static_cast<std::uint8_t>(-(quarters & 1))));
    const auto half = hn::MaskFromVec(hn::Set(d, static_cast<std::uint8_t>(-(quarters >> 1 & 1))));
    auto sums = hn::Zero(hn::Repartition<std::uint64_t, Bytes16>());
    for (int row = 0; row < 3; ++row, right += stride) {
      const VecB before = hn::LoadU(d, right), behind = hn::LoadU(d, right + 1);
      const VecB middle = hn::AverageRound(before, behind);
      const VecB from = hn::IfThenElse(half, middle, before), to = hn::IfThenElse(half, behind, middle);
      const VecB other = Windows(hn::IfThenElse(odd, hn::AverageRound(from, to), from));
      const VecB difference =
          hn::Or(hn::SaturatedSub(left_[row], other), hn::SaturatedSub(other, left_[row]));
      sums = hn::Add(sums, hn::SumsOf8(difference));
    }
    HWY_ALIGN std::uint64_t both[2];
    hn::Store(sums, hn::Repartition<std::uint64_t, Bytes16>(), both);
    return static_cast<int>(std::min(both[0], both[1]));
  }

 private:
  /// The five pixels up to the middle one in the lower half, the five from it on in the upper half.
  static HWY_INLINE VecB Windows(VecB pixels) {
    constexpr std::uint8_t none = 0x80;
    HWY_ALIGN static constexpr std::uint8_t kIndices[16] = {0, 1, 2, 3, 4, none, none, none,
                                                            4, 5, 6, 7, 8, none, none, none};
    return hn::TableLookupBytesOr0(pixels, hn::Load(Bytes16(), kIndices));
  }
  const EdgeImages& images_;
  int u_, v_;
  VecB left_[3];
};

/// Calls `use(i)` for each lane i of a mask.
template <class D, class Mask, class Use>
HWY_INLINE void ForEachLane(D d, Mask mask, const Use& use) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  std::uint64_t bits;
  std::memcpy(&bits, bytes, 8);
  for (; bits != 0; bits &= bits - 1) use(std::countr_zero(bits));
}

/// Finds the disparities that pixels of a row may take from those at `reach`: far from their own, or any
/// where they have none, and leading into the right image.
void FindCandidates(const GivenRows& given, int width, int reach, float min_jump, EdgeCandidates& found) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const int lanes = static_cast<int>(hn::Lanes(df));
  const auto v_jump = hn::Set(df, min_jump);
  const auto last = hn::Set(df, static_cast<float>(width - 1));
  found.pixels.clear();
  found.candidates.clear();
  for (int u = 0; u < width; u += lanes) {
    const auto own = hn::LoadU(df, given.row + u);
    const auto column = hn::ConvertTo(df, hn::Iota(di, u));
    // Comparisons with NaN are false.
    const auto may_take = [&](const float* other) HWY_ATTR {
      const auto d = hn::LoadU(df, other + u);
      const auto x = hn::Sub(column, d);
      const auto same = hn::Le(hn::Abs(hn::Sub(d, own)), v_jump);
      return hn::AndNot(same, hn::And(hn::Ge(x, hn::Zero(df)), hn::Le(x, last)));
    };
    const float* const left = given.row - reach;
    const float* const right = given.row + reach;
    const auto from_left = may_take(left), from_right = may_take(right);
    const auto from_above = may_take(given.above), from_below = may_take(given.below);
    const auto any = hn::Or(hn::Or(from_left, from_right), hn::Or(from_above, from_below));
    if (hn::AllFalse(df, any)) continue;
    ForEachLane(df, any, [&](int i) { found.pixels.push_back(u + i); });
    ForEachLane(df, from_left, [&](int i) { found.candidates.push_back({u + i, left[u + i]}); });
    ForEachLane(df, from_right, [&](int i) { found.candidates.push_back({u + i, right[u + i]}); });
    ForEachLane(df, from_above, [&](int i) { found.candidates.push_back({u + i, given.above[u + i]}); });
    ForEachLane(df, from_below, [&](int i) { found.candidates.push_back({u + i, given.below[u + i]}); });
  }
}

/// Each pixel at an edge gets the best among its own and its neighbours' disparities.
void SharpenRow(const EdgeImages& images, const GivenRows& given, int v, const DepthEdgeSettings& settings,
                EdgeCandidates& found, float* disparity) {
  FindCandidates(given, images.width, settings.reach_px, settings.min_jump_px, found);
  found.least.resize(images.width + kBehind);
  const int max_fill = static_cast<int>(settings.max_fill_difference * kWindowPixels);
  for (const int u : found.pixels) {
    const float own = given.row[u];
    const int sum = WindowDifference(images, u, v).At(std::isnan(own) ? 0.0f : own);
    found.least[u] = std::isnan(own) ? max_fill : static_cast<int>(kClearlyBetter * static_cast<float>(sum));
  }
  for (const EdgeCandidates::Candidate& c : found.candidates) {
    const int sum = WindowDifference(images, c.u, v).At(c.disparity);
    const bool better = sum < found.least[c.u];
    found.least[c.u] = better ? sum : found.least[c.u];
    disparity[c.u] = better ? c.disparity : disparity[c.u];
  }
}

/// Of two pixels that claim the same place of the right image, one is wrong or hidden. They stand left and
/// right of a step towards the camera.
void SettleRow(const EdgeImages& images, int v, float min_jump, std::vector<int>& begins, float* disparity) {
  const hn::ScalableTag<float> df;
  const int lanes = static_cast<int>(hn::Lanes(df));
  const auto v_jump = hn::Set(df, min_jump);
  const int width = images.width;
  const auto place = [&](int u) { return static_cast<float>(u) - disparity[u]; };
  const auto settle = [&](int begin) HWY_ATTR {  // the nearer surface's first pixel
    const int first = std::max(0, static_cast<int>(place(begin) - kSamePlace));
    int last = begin - 1;
    while (last >= first && std::isnan(disparity[last])) --last;
    if (last < first || disparity[begin] - disparity[last] <= min_jump) return;
    const float place_of_last = place(last);
    // What cannot claim a place from the nearer surface's first one on, is passed over; unknown pixels too:
    // comparisons with NaN are false.
    int further = first;
    for (int near = begin; near < width; ++near) {
      if (std::isnan(disparity[near])) continue;
      if (place(near) > place_of_last + kSamePlace) break;
      while (further < last && !(place(further) >= place(near) - kSamePlace)) ++further;
      if (place(further) > place(near) + kSamePlace) continue;
      if (!(disparity[near] - disparity[further] > min_jump)) break;
      const int difference = WindowDifference(images, further, v).At(disparity[further]) - kNearerHandicap -
                             WindowDifference(images, near, v).At(disparity[near]);
      disparity[difference < 0 ? near : further] = kUnknown;
    }
  };
  // All of them before any is settled: what is found must not depend on the length of vectors.
  begins.clear();
  for (int block = 0; block < width; block += lanes) {
    const auto d = hn::LoadU(df, disparity + block);
    const auto step = hn::Sub(d, hn::LoadU(df, disparity + block - 1));
    // Known, and the one before is unknown or further.
    const auto begin = hn::AndNot(hn::Le(step, v_jump), hn::Eq(d, d));
    if (!hn::AllFalse(df, begin)) ForEachLane(df, begin, [&](int i) { begins.push_back(block + i); });
  }
  for (const int begin : begins)
    if (!std::isnan(disparity[begin])) settle(begin);
}

/// Unknown pixels near known ones take one of their disparities where the images agree and the place it leads
/// to in the right image lies between those of the known pixels to the left and to the right: nobody's.
void FillRow(const EdgeImages& images, const GivenRows& given, int v, const DepthEdgeSettings& settings,
             float* disparity) {
  const hn::ScalableTag<float> df;
  const int lanes = static_cast<int>(hn::Lanes(df));
  const int width = images.width, reach = settings.reach_px;
  const int max_fill = static_cast<int>(settings.max_fill_difference * kWindowPixels);
  const auto fill = [&](int begin) HWY_ATTR {  // until the next known pixel; returns it
    int end = begin + 1;
    while (end < width && std::isnan(disparity[end])) ++end;
    for (int i = 0; i < kMaxUnbelieved && end < width && !std::isnan(disparity[end]); ++i) {
      if (WindowDifference(images, end, v).At(disparity[end]) <= kMaxDifferenceAtGap * kWindowPixels) break;
      disparity[end++] = kUnknown;
    }
    const float d_left = disparity[begin - 1], d_right = disparity[end];
    const float place_left = begin > 0 ? static_cast<float>(begin - 1) - d_left : -1.0f;
    const float place_right =
        end < width && !std::isnan(d_right) ? static_cast<float>(end) - d_right : static_cast<float>(width);
    for (int u = begin; u < end; ++u) {
      const float candidates[] = {u - begin < reach ? d_left : kUnknown,
                                  end - u <= reach ? d_right : kUnknown, given.above[u], given.below[u]};
      int least = max_fill;
      for (const float d : candidates) {
        const float place = static_cast<float>(u) - d;
        if (!(place > place_left + kSamePlace && place < place_right - kSamePlace)) continue;
        const int sum = WindowDifference(images, u, v).At(d);
        if (sum < least) least = sum, disparity[u] = d;
      }
    }
    return end;
  };
  for (int u = 0; u < width;) {
    const auto d = hn::LoadU(df, disparity + u);
    if (hn::AllTrue(df, hn::Eq(d, d))) {  // all known
      u += lanes;
      continue;
    }
    while (u < width && !std::isnan(disparity[u])) ++u;
    if (u < width) u = fill(u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(SharpenRow);
HWY_EXPORT(SettleRow);
HWY_EXPORT(FillRow);

namespace {

/// The right image with the left one's brightness: mean and spread of the pixels that correspond.
void MatchBrightness(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& disparity,
                     cv::Mat1b& matched) {
  double n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8)
    for (int u = 0; u < left.cols; u += 2) {
      const float x = static_cast<float>(u) - disparity(v, u);
      if (!(x >= 0.0f)) continue;
      const int l = left(v, u), r = right(v, std::min(static_cast<int>(x + 0.5f), right.cols - 1));
      n += 1, l1 += l, r1 += r, l2 += l * l, r2 += r * r;
    }
  const double var_l = n * l2 - l1 * l1, var_r = n * r2 - r1 * r1;
  const bool enough = n >= 100 && var_l > 0 && var_r > 0;
  const double gain = enough ? std::clamp(std::sqrt(var_l / var_r), 0.5, 2.0) : 1.0;
  const double offset = enough ? (l1 - gain * r1) / n : 0.0;
  cv::Mat1b table(1, 256);
  for (int i = 0; i < 256; ++i) table(i) = cv::saturate_cast<std::uint8_t>(gain * i + offset);
  cv::LUT(right, table, matched);
}

}  // namespace

class DepthEdgeSharpener::Scratch {
 public:
  struct OfOneThread {
    EdgeCandidates found;
    std::vector<int> begins;
    std::vector<float> row;
  };
  EdgeImages images;
  cv::Mat1b matched;
  cv::Mat1f given;
  tbb::enumerable_thread_specific<OfOneThread> threads;
};

DepthEdgeSharpener::DepthEdgeSharpener(const DepthEdgeSettings& settings)
    : settings_(settings), scratch_(std::make_unique<Scratch>()) {}
DepthEdgeSharpener::~DepthEdgeSharpener() = default;

void DepthEdgeSharpener::Sharpen(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity) {
  const int width = left.cols, height = left.rows, reach = settings_.reach_px;
  EdgeImages& images = scratch_->images;
  images.width = width;
  MatchBrightness(left, right, disparity, scratch_->matched);
  cv::copyMakeBorder(left, images.left, 1, 1, kImageBorder, kBehind, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(scratch_->matched, images.right, 1, 1, kImageBorder, kBehind, cv::BORDER_REPLICATE);
  cv::Mat1f& given = scratch_->given;
  for (int round = 0; round < settings_.rounds; ++round) {
    cv::copyMakeBorder(disparity, given, 0, 0, kRowMargin, kBehind, cv::BORDER_CONSTANT, kUnknown);
    ParallelFor(height, [&](int v) {
      Scratch::OfOneThread& mine = scratch_->threads.local();
      mine.row.assign(given[v], given[v] + given.cols);
      float* row = mine.row.data() + kRowMargin;
      const GivenRows rows = {given[v] + kRowMargin, given[std::max(v - reach, 0)] + kRowMargin,
                              given[std::min(v + reach, height - 1)] + kRowMargin};
      HWY_DYNAMIC_DISPATCH(SharpenRow)(images, rows, v, settings_, mine.found, row);
      HWY_DYNAMIC_DISPATCH(SettleRow)(images, v, settings_.min_jump_px, mine.begins, row);
      HWY_DYNAMIC_DISPATCH(FillRow)(images, rows, v, settings_, row);
      std::copy_n(row, width, disparity[v]);
    });
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
