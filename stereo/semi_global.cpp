// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/semi_global.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <tbb/enumerable_thread_specific.h>

#include "core/check.h"
#include "core/parallel_for.h"

namespace terrace {
namespace {

constexpr int kNearRange = 16;
constexpr int kFirstStep = 16;

/// Of the sums of winners of chance half are above this, of right ones hardly any but in the dark.
constexpr int MaxGoodSum(int num_paths) { return num_paths == 2 ? 45 : 90; }

}  // namespace

/// Whether what is expected in a strip is found, tile by tile: where the range does not hold what there is to
/// see, most pixels have no match that both views agree on, or a poor one, or one at the edge of the range.
class SemiGlobalMatcher::Evidence {
 public:
  Evidence(const ExpectedDisparities& expected, const SearchRange& range, const Strip& strip, int num_paths)
      : expected_(expected),
        range_(range),
        strip_(strip),
        max_sum_(MaxGoodSum(num_paths)),
        num_pixels_(expected.columns),
        num_poor_(num_pixels_) {}

  void AddRow(int v, const float* disparity, const std::uint8_t* best_sums, int width) {
    const auto lowest = static_cast<float>(range_.first > 0 ? range_.first + 1 : -1);
    const auto highest = static_cast<float>(range_.first + range_.count - 2);
    // Further left, not all of the range is in the right image.
    for (int u = range_.first + range_.count - 1; u < width; ++u) {
      const bool good = disparity[u] > lowest && disparity[u] < highest && best_sums[u] <= max_sum_;
      ++num_pixels_[u / expected_.tile_px];
      num_poor_[u / expected_.tile_px] += !good;
    }
    if ((v + 1) % expected_.tile_px == 0 || v + 1 == strip_.bottom) FinishTiles(v / expected_.tile_px);
  }

  bool found() const { return found_; }

 private:
  void FinishTiles(int row) {
    const double min_pixels = kMinShareSeen * expected_.tile_px * expected_.tile_px;
    for (int column = 0; column < expected_.columns; ++column) {
      const bool known = expected_.known[static_cast<std::size_t>(row) * expected_.columns + column];
      if (known && num_pixels_[column] >= min_pixels &&
          num_poor_[column] > kMaxSharePoor * num_pixels_[column])
        found_ = false;
      num_pixels_[column] = num_poor_[column] = 0;
    }
  }

  /// Tiles of which less can be judged say nothing.
  static constexpr double kMinShareSeen = 0.25;
  /// On a walk 0.5 % of the tiles have more with a right range, and seven of ten with a wrong one.
  static constexpr double kMaxSharePoor = 0.4;
  const ExpectedDisparities& expected_;
  SearchRange range_;
  Strip strip_;
  int max_sum_;
  bool found_ = true;
  std::vector<int> num_pixels_, num_poor_;
};

/// What one thread needs while it works on a strip.
class SemiGlobalMatcher::Scratch {
 public:
  struct OfOneThread {
    PathAggregator aggregator;
    WinnerChooser winner;
  };
  explicit Scratch(const WinnerRules& rules)
      : threads_([rules] {
          return OfOneThread{PathAggregator(), WinnerChooser(rules)};
        }) {}
  OfOneThread& local() { return threads_.local(); }

 private:
  tbb::enumerable_thread_specific<OfOneThread> threads_;
};

SemiGlobalMatcher::SemiGlobalMatcher(SemiGlobalSettings settings)
    : settings_(std::move(settings)), scratch_(std::make_unique<Scratch>(settings_.winner)) {}
SemiGlobalMatcher::~SemiGlobalMatcher() = default;

void SemiGlobalMatcher::Match(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities,
                              cv::Mat1f& disparity, const ExpectedDisparities& expected) {
  const int num_strips = (left.rows + settings_.rows_per_strip - 1) / settings_.rows_per_strip;
  TERRACE_CHECK(expected.strips.empty() || (static_cast<int>(expected.strips.size()) == num_strips &&
                                            settings_.rows_per_strip % expected.tile_px == 0 &&
                                            expected.columns * expected.tile_px >= left.cols),
                expected.strips.size(), num_strips, expected.tile_px, expected.columns);
  Prepare(left, right);
  PrepareRanges(left.size(), expected.strips);
  doubtful_.Begin(left.size());
  disparity.create(left.size());
  ForEachStrip(left.rows, [&](Strip strip) {
    if (!expected.strips.empty()) {
      const SearchRange& range = expected.strips[strip.top / settings_.rows_per_strip];
      if (range.count < num_disparities) {
        strip.num_disparities = range.count;
        Evidence evidence(expected, range, strip, settings_.num_paths);
        MatchStrip(strip, ranges_[range.first / kFirstStep], nullptr, &evidence, disparity);
        if (evidence.found()) return;
      }
    }
    strip.num_disparities = num_disparities;
    MatchStrip(strip, ranges_[0], nullptr, nullptr, disparity);
  });
}

void SemiGlobalMatcher::MatchNear(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& rough,
                                  cv::Mat1f& disparity) {
  near_first_.create(rough.size());
  ParallelFor(rough.rows, [&](int v) {
    const float* from = rough[v];
    std::int16_t* first = near_first_[v];
    for (int u = 0; u < rough.cols; ++u)
      first[u] = static_cast<std::int16_t>(static_cast<int>(from[u] + 0.5f) - kNearRange / 2);
  });
  near_ranges_.Set(near_first_);
  alignas(64) std::array<std::uint8_t, kNearRange> prior_costs;
  for (int k = 0; k < kNearRange; ++k)  // the largest disparity first
    prior_costs[k] = static_cast<std::uint8_t>(std::abs(kNearRange - 1 - k - kNearRange / 2) / 2);
  Prepare(left, right);
  disparity.create(left.size());
  ForEachStrip(left.rows, [&](Strip strip) {
    strip.num_disparities = kNearRange;
    MatchStrip(strip, near_ranges_, prior_costs.data(), nullptr, disparity);
  });
}

void SemiGlobalMatcher::Prepare(const cv::Mat1b& left, const cv::Mat1b& right) {
  left_census_.Compute(left, settings_.census);
  right_census_.Compute(right, settings_.census);
  step_penalties_.Compute(left, settings_.penalties, settings_.num_paths == 8);
}

void SemiGlobalMatcher::PrepareRanges(const cv::Size& size, const std::vector<SearchRange>& strips) {
  int max_first = 0;
  for (const SearchRange& range : strips) max_first = std::max(max_first, range.first);
  if (size != ranges_size_) ranges_.clear();
  ranges_size_ = size;
  for (int first = static_cast<int>(ranges_.size()) * kFirstStep; first <= max_first; first += kFirstStep)
    ranges_.emplace_back().Set(size.width, size.height, first);
}

template <typename Work>
void SemiGlobalMatcher::ForEachStrip(int height, const Work& work) const {
  ParallelFor((height + settings_.rows_per_strip - 1) / settings_.rows_per_strip, [&](int i) {
    Strip strip;
    strip.top = i * settings_.rows_per_strip;
    strip.bottom = std::min(strip.top + settings_.rows_per_strip, height);
    strip.lead_in = settings_.lead_in;
    work(strip);
  });
}

void SemiGlobalMatcher::MatchStrip(const Strip& strip, const DisparityRanges& ranges,
                                   const std::uint8_t* prior_costs, Evidence* evidence,
                                   cv::Mat1f& disparity) {
  Scratch::OfOneThread& mine = scratch_->local();
  const MatchingProblem problem{&left_census_,      &right_census_,         &ranges,
                                &step_penalties_,   settings_.penalties.p1, prior_costs,
                                settings_.num_paths};
  mine.aggregator.Aggregate(problem, strip, [&](int v, const std::uint8_t* sums) {
    mine.winner.Choose({sums, disparity.cols, strip.num_disparities, ranges.First(v)}, disparity[v]);
    if (ranges.uniform() && !evidence)
      doubtful_.AddRow(v, disparity[v], mine.winner.best_sums(), MaxGoodSum(settings_.num_paths),
                       static_cast<float>(strip.num_disparities - 1));
    if (evidence) evidence->AddRow(v, disparity[v], mine.winner.best_sums(), disparity.cols);
  });
}

}  // namespace terrace
