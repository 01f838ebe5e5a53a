// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/depth_edges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
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
constexpr int kBehind = 64;      // and right of them, which vectors touch
constexpr int kHalfWindow = 4;   // of the windows' common width
constexpr int kWindowPixels = 15;
constexpr int kUnitsPerPx = UnitImage::kUnitsPerPx;
constexpr float kClearlyBetter = 0.8f;       // of its own difference, to leave one's disparity for another
constexpr int kSamePlace = kUnitsPerPx / 2;  // between claims on the right image
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
  const std::int16_t *row, *above, *below;
};

/// What the pixels of one row may take instead of their own disparity.
struct EdgeCandidates {
  struct Candidate {
    int u;
    std::int16_t disparity;
  };
  std::vector<Candidate> candidates;
  std::vector<int> pixels;  // that have any
  std::vector<int> least;   // window difference of each pixel's best one
};

/// DepthEdgeSettings in units, and in sums over windows.
struct EdgeLimits {
  int reach, min_jump, max_fill;
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
  /// @param disparity  in units; leads to a place in the right image
  HWY_INLINE int At(int disparity) const {
    const Bytes16 d;
    constexpr int kUnitsPerQuarter = kUnitsPerPx / 4;
    const int quarters = (u_ * kUnitsPerPx - disparity + kUnitsPerQuarter / 2) / kUnitsPerQuarter;
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
void FindCandidates(const GivenRows& given, int width, int reach, int min_jump, EdgeCandidates& found) {
  const hn::ScalableTag<std::int16_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto zero = hn::Zero(d), jump = hn::Set(d, static_cast<std::int16_t>(min_jump));
  const auto furthest_column = hn::Set(d, UnitImage::kMaxUnits / kUnitsPerPx);
  found.pixels.clear();
  found.candidates.clear();
  for (int u = 0; u < width; u += lanes) {
    const auto own = hn::LoadU(d, given.row + u);
    const auto own_known = hn::Gt(own, zero);
    // Further right, every disparity leads into the right image.
    const auto column = hn::Min(hn::Iota(d, static_cast<std::int16_t>(u)), furthest_column);
    const auto limit = hn::Mul(column, hn::Set(d, kUnitsPerPx));
    const auto may_take = [&](const std::int16_t* other) HWY_ATTR {
      const auto disparity = hn::LoadU(d, other + u);
      const auto far = hn::Gt(hn::Abs(hn::Sub(disparity, own)), jump);
      const auto possible = hn::AndNot(hn::Gt(disparity, limit), hn::Gt(disparity, zero));
      return hn::And(possible, hn::Or(far, hn::Not(own_known)));
    };
    const std::int16_t* const left = given.row - reach;
    const std::int16_t* const right = given.row + reach;
    const auto from_left = may_take(left), from_right = may_take(right);
    const auto from_above = may_take(given.above), from_below = may_take(given.below);
    const auto inside = hn::FirstN(d, static_cast<std::size_t>(width - u));
    const auto any = hn::And(inside, hn::Or(hn::Or(from_left, from_right), hn::Or(from_above, from_below)));
    if (hn::AllFalse(d, any)) continue;
    const auto add = [&](auto mask, const std::int16_t* other) HWY_ATTR {
      ForEachLane(d, hn::And(mask, inside), [&](int i) {
        found.candidates.push_back({u + i, other[u + i]});
      });
    };
    ForEachLane(d, any, [&](int i) { found.pixels.push_back(u + i); });
    add(from_left, left);
    add(from_right, right);
    add(from_above, given.above);
    add(from_below, given.below);
  }
}

/// Each pixel at an edge gets the best among its own and its neighbours' disparities.
void SharpenRow(const EdgeImages& images, const GivenRows& given, int v, const EdgeLimits& limits,
                EdgeCandidates& found, std::int16_t* disparity) {
  FindCandidates(given, images.width, limits.reach, limits.min_jump, found);
  found.least.resize(images.width);
  for (const int u : found.pixels) {
    const int own = given.row[u];
    const int sum = own == 0 ? 0 : WindowDifference(images, u, v).At(own);
    found.least[u] = own == 0 ? limits.max_fill : static_cast<int>(kClearlyBetter * static_cast<float>(sum));
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
void SettleRow(const EdgeImages& images, int v, const EdgeLimits& limits, std::vector<int>& begins,
               std::int16_t* disparity) {
  const hn::ScalableTag<std::int16_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = images.width, min_jump = limits.min_jump;
  const auto place = [&](int u) { return u * kUnitsPerPx - disparity[u]; };
  const auto settle = [&](int begin) HWY_ATTR {  // the nearer surface's first pixel
    const int first = std::max(0, (place(begin) - kSamePlace) / kUnitsPerPx);
    int last = begin - 1;
    while (last >= first && disparity[last] == 0) --last;
    if (last < first || disparity[begin] - disparity[last] <= min_jump) return;
    const int place_of_last = place(last);
    // What cannot claim a place from the nearer surface's first one on, is passed over.
    int further = first;
    for (int near = begin; near < width; ++near) {
      if (disparity[near] == 0) continue;
      if (place(near) > place_of_last + kSamePlace) break;
      while (further < last && (disparity[further] == 0 || place(further) < place(near) - kSamePlace))
        ++further;
      if (disparity[further] == 0) break;
      if (place(further) > place(near) + kSamePlace) continue;
      if (disparity[near] - disparity[further] <= min_jump) break;
      const int difference = WindowDifference(images, further, v).At(disparity[further]) - kNearerHandicap -
                             WindowDifference(images, near, v).At(disparity[near]);
      disparity[difference < 0 ? near : further] = 0;
    }
  };
  // All of them before any is settled: what is found must not depend on the length of vectors.
  begins.clear();
  const auto jump = hn::Set(d, static_cast<std::int16_t>(min_jump));
  for (int block = 0; block < width; block += lanes) {
    const auto own = hn::LoadU(d, disparity + block), before = hn::LoadU(d, disparity + block - 1);
    // Known, and the one before is unknown or further.
    const auto step = hn::Or(hn::Gt(hn::Sub(own, before), jump), hn::Eq(before, hn::Zero(d)));
    const auto begin = hn::And(hn::Gt(own, hn::Zero(d)), step);
    if (!hn::AllFalse(d, begin)) ForEachLane(d, begin, [&](int i) { begins.push_back(block + i); });
  }
  for (const int begin : begins)
    if (disparity[begin] != 0) settle(begin);
}

/// Unknown pixels near known ones take one of their disparities where the images agree and the place it leads
/// to in the right image lies between those of the known pixels to the left and to the right: nobody's.
void FillRow(const EdgeImages& images, const GivenRows& given, int v, const EdgeLimits& limits,
             std::int16_t* disparity) {
  const hn::ScalableTag<std::int16_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = images.width, reach = limits.reach;
  const auto fill = [&](int begin) HWY_ATTR {  // until the next known pixel; returns it
    int end = begin + 1;
    while (end < width && disparity[end] == 0) ++end;
    for (int i = 0; i < kMaxUnbelieved && end < width && disparity[end] != 0; ++i) {
      if (WindowDifference(images, end, v).At(disparity[end]) <= kMaxDifferenceAtGap * kWindowPixels) break;
      disparity[end++] = 0;
    }
    const std::int16_t d_left = disparity[begin - 1], d_right = disparity[end];
    const int place_left = (begin - 1) * kUnitsPerPx - d_left;
    const int place_right = (end < width && d_right != 0 ? end : width) * kUnitsPerPx - d_right;
    for (int u = begin; u < end; ++u) {
      const std::int16_t candidates[] = {u - begin < reach ? d_left : std::int16_t{0},
                                         end - u <= reach ? d_right : std::int16_t{0}, given.above[u],
                                         given.below[u]};
      int least = limits.max_fill;
      for (const std::int16_t candidate : candidates) {
        const int place = u * kUnitsPerPx - candidate;
        if (candidate == 0 || place <= place_left + kSamePlace || place >= place_right - kSamePlace) continue;
        const int sum = WindowDifference(images, u, v).At(candidate);
        if (sum < least) least = sum, disparity[u] = candidate;
      }
    }
    return end;
  };
  for (int u = 0; u < width;) {
    if (hn::AllFalse(d, hn::Eq(hn::LoadU(d, disparity + u), hn::Zero(d)))) {  // all known
      u += lanes;
      continue;
    }
    while (u < width && disparity[u] != 0) ++u;
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
void MatchBrightness(const cv::Mat1b& left, const cv::Mat1b& right, const UnitImage& disparity,
                     cv::Mat1b& matched) {
  double n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8)
    for (int u = 0; u < left.cols; u += 2) {
      const int units = disparity.Row(v)[u], place = u * kUnitsPerPx - units;
      if (units == 0 || place < 0) continue;
      const int l = left(v, u), r = right(v, (place + kUnitsPerPx / 2) / kUnitsPerPx);
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
    std::vector<std::int16_t> slopes, above, below;

    /// The rows above and below as they would be in row v on its steep surfaces.
    GivenRows AlongSlopes(const GivenRows& rows, int v, int v_above, int v_below, int width,
                          const Steepness& steepness) {
      const std::size_t size = static_cast<std::size_t>(width) + kBehind;
      slopes.resize(size);
      if (!steepness.surfaces || !steepness.surfaces->SlopesOfRow(v, steepness.scale, width, slopes.data()))
        return rows;
      const auto move = [&](const std::int16_t* row, int rows_below, std::vector<std::int16_t>& to) {
        to.resize(size);
        for (int u = 0; u < width; ++u) {
          const int moved = std::clamp(row[u] + rows_below * slopes[u], 1, UnitImage::kMaxUnits);
          to[u] = static_cast<std::int16_t>(row[u] == 0 ? 0 : moved);
        }
        return to.data();
      };
      return {rows.row, move(rows.above, v - v_above, above), move(rows.below, v - v_below, below)};
    }
  };
  EdgeImages images;
  cv::Mat1b matched;
  UnitImage sharpened;
  tbb::enumerable_thread_specific<OfOneThread> threads;
};

DepthEdgeSharpener::DepthEdgeSharpener(const DepthEdgeSettings& settings)
    : settings_(settings), scratch_(std::make_unique<Scratch>()) {}
DepthEdgeSharpener::~DepthEdgeSharpener() = default;

void DepthEdgeSharpener::Sharpen(const cv::Mat1b& left, const cv::Mat1b& right, UnitImage& disparity,
                                 const Steepness& steepness) {
  const int width = left.cols, height = left.rows;
  const EdgeLimits limits = {settings_.reach_px,
                             static_cast<int>(std::lround(settings_.min_jump_px * kUnitsPerPx)),
                             static_cast<int>(settings_.max_fill_difference * kWindowPixels)};
  EdgeImages& images = scratch_->images;
  images.width = width;
  MatchBrightness(left, right, disparity, scratch_->matched);
  cv::copyMakeBorder(left, images.left, 1, 1, kImageBorder, kBehind, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(scratch_->matched, images.right, 1, 1, kImageBorder, kBehind, cv::BORDER_REPLICATE);
  UnitImage& sharpened = scratch_->sharpened;
  sharpened.Create(left.size());
  for (int round = 0; round < settings_.rounds; ++round) {
    ParallelFor(height, [&](int v) {
      Scratch::OfOneThread& mine = scratch_->threads.local();
      const int v_above = std::max(v - limits.reach, 0), v_below = std::min(v + limits.reach, height - 1);
      const GivenRows rows =
          mine.AlongSlopes({disparity.Row(v), disparity.Row(v_above), disparity.Row(v_below)}, v, v_above,
                           v_below, width, steepness);
      std::int16_t* row = sharpened.Row(v);
      std::copy_n(rows.row, width, row);
      HWY_DYNAMIC_DISPATCH(SharpenRow)(images, rows, v, limits, mine.found, row);
      HWY_DYNAMIC_DISPATCH(SettleRow)(images, v, limits, mine.begins, row);
      HWY_DYNAMIC_DISPATCH(FillRow)(images, rows, v, limits, row);
    });
    std::swap(disparity, sharpened);
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
