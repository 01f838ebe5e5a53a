// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/step_penalties.h"

#include <algorithm>
#include <cstring>

#include "core/check.h"
#include "stereo/path_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/step_penalties.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void StepPenaltyRow(const std::uint8_t* pixel, const std::uint8_t* neighbour, int width, std::uint8_t p2_max,
                    std::uint8_t p2_min, std::uint8_t* p2) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto most = hn::Set(d, p2_max), least = hn::Set(d, p2_min);
  const auto store = [&](int u) HWY_ATTR {
    const auto a = hn::LoadU(d, pixel + u), b = hn::LoadU(d, neighbour + u);
    const auto difference = hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
    hn::StoreU(hn::Max(least, hn::SaturatedSub(most, difference)), d, p2 + u);
  };
  int u = 0;
  for (; u + lanes <= width; u += lanes) store(u);
  for (; u < width; ++u) {
    const int difference = pixel[u] > neighbour[u] ? pixel[u] - neighbour[u] : neighbour[u] - pixel[u];
    p2[u] = static_cast<std::uint8_t>(std::max<int>(p2_min, p2_max - difference));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(StepPenaltyRow);

/// Where a step comes from, by kind.
constexpr struct { int du, dv; } kFrom[] = {{-1, 0}, {0, -1}, {-1, -1}, {1, -1}};

void StepPenalties::Compute(const cv::Mat1b& image, const PathPenalties& penalties, bool diagonals) {
  TERRACE_CHECK(0 <= penalties.p1 && penalties.p1 <= penalties.p2_min &&
                    penalties.p2_min <= penalties.p2_max && penalties.p2_max <= 50,
                penalties.p1, penalties.p2_min, penalties.p2_max);
  stride_ = static_cast<std::size_t>((image.cols + 1 + 63) / 64 * 64);
  num_kinds_ = diagonals ? 4 : 2;
  bytes_.Reserve(num_kinds_ * stride_ * image.rows + kBlock);  // vectors read on behind the last
  const std::uint8_t p2_max = static_cast<std::uint8_t>(penalties.p2_max);
  const std::uint8_t p2_min = static_cast<std::uint8_t>(penalties.p2_min);
  for (int v = 0; v < image.rows; ++v)
    for (int kind = 0; kind < num_kinds_; ++kind) {
      const auto [du, dv] = kFrom[kind];
      const std::uint8_t* neighbours = image[std::max(v + dv, 0)];
      std::uint8_t* p2 = bytes_.data() + (static_cast<std::size_t>(v) * num_kinds_ + kind) * stride_;
      // No step comes from outside; the paths from row to row run on to a multiple of 16 pixels.
      const int begin = std::max(-du, 0), end = image.cols - std::max(du, 0);
      std::memset(p2, p2_max, begin);
      std::memset(p2 + end, p2_max, stride_ - end);
      HWY_DYNAMIC_DISPATCH(StepPenaltyRow)
      (image[v] + begin, neighbours + begin + du, end - begin, p2_max, p2_min, p2 + begin);
    }
}

}  // namespace terrace
#endif  // HWY_ONCE
