// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/semi_global.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <tbb/enumerable_thread_specific.h>

#include "core/parallel_for.h"

namespace terrace {
namespace {

constexpr int kNearRange = 16;

}  // namespace

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
                              cv::Mat1f& disparity) {
  ranges_.Set(left.cols, left.rows, 0);
  MatchStrips(left, right, num_disparities, nullptr, disparity);
}

void SemiGlobalMatcher::MatchNear(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& rough,
                                  cv::Mat1f& disparity) {
  cv::Mat_<std::int16_t> first(rough.size());
  for (int v = 0; v < rough.rows; ++v)
    for (int u = 0; u < rough.cols; ++u)
      first(v, u) = static_cast<std::int16_t>(std::lround(rough(v, u)) - kNearRange / 2);
  ranges_.Set(first);
  alignas(64) std::array<std::uint8_t, kNearRange> prior_costs;
  for (int k = 0; k < kNearRange; ++k)  // the largest disparity first
    prior_costs[k] = static_cast<std::uint8_t>(std::abs(kNearRange - 1 - k - kNearRange / 2) / 2);
  MatchStrips(left, right, kNearRange, prior_costs.data(), disparity);
}

void SemiGlobalMatcher::MatchStrips(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities,
                                    const std::uint8_t* prior_costs, cv::Mat1f& disparity) {
  left_census_.Compute(left, settings_.census);
  right_census_.Compute(right, settings_.census);
  step_penalties_.Compute(left, settings_.penalties);
  const MatchingProblem problem{&left_census_,    &right_census_,         &ranges_,
                                &step_penalties_, settings_.penalties.p1, prior_costs};
  disparity.create(left.size());

  const int num_strips = (left.rows + settings_.rows_per_strip - 1) / settings_.rows_per_strip;
  ParallelFor(num_strips, [&](int i) {
    Scratch::OfOneThread& mine = scratch_->local();
    Strip strip;
    strip.top = i * settings_.rows_per_strip;
    strip.bottom = std::min(strip.top + settings_.rows_per_strip, left.rows);
    strip.lead_in = settings_.lead_in;
    strip.num_disparities = num_disparities;
    mine.aggregator.Aggregate(problem, strip, [&](int v, const std::uint8_t* sums) {
      mine.winner.Choose({sums, left.cols, num_disparities, ranges_.First(v)}, disparity[v]);
    });
  });
}

}  // namespace terrace
