// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_matcher.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace terrace {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// What OpenCV's parabola through the matching costs leaves on textured ground.
constexpr float kSigmaPx = 0.25f;

}  // namespace

std::vector<std::string> DisparityConfig::Problems() const {
  std::vector<std::string> problems;
  if (max_disparity_px < 16 || max_disparity_px > 256 || max_disparity_px % 16 != 0)
    problems.push_back("max_disparity_px is " + std::to_string(max_disparity_px) +
                       ", must be a multiple of 16 from 16 to 256");
  if (!(max_left_right_error_px >= 0.0))
    problems.push_back("max_left_right_error_px is " + std::to_string(max_left_right_error_px) +
                       ", must not be negative");
  return problems;
}

class DisparityMatcher::Impl {
 public:
  explicit Impl(const DisparityConfig& config) : config_(config) {
    const int left_right = static_cast<int>(std::lround(config.max_left_right_error_px));
    sgbm_ = cv::StereoSGBM::create(0, config.max_disparity_px, 5, 200, 800, left_right, 63, 10, 100, 2,
                                   cv::StereoSGBM::MODE_SGBM);
  }

  DisparityImage Match(const StereoFrame& frame) {
    // Without the border nothing would be found in the leftmost max_disparity_px columns.
    const int border = config_.max_disparity_px;
    cv::copyMakeBorder(frame.left, left_, 0, 0, border, 0, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(frame.right, right_, 0, 0, border, 0, cv::BORDER_REPLICATE);
    sgbm_->compute(left_, right_, sixteenths_);

    DisparityImage result{frame.frame_id, frame.t_capture, {}, {}};
    result.disparity_px.create(frame.left.size());
    result.sigma_px.create(frame.left.size());
    for (int v = 0; v < frame.left.rows; ++v) {
      const short* found = sixteenths_.ptr<short>(v) + border;
      for (int u = 0; u < frame.left.cols; ++u) {
        const bool known = found[u] > 0;
        result.disparity_px(v, u) = known ? static_cast<float>(found[u]) / 16.0f : kUnknown;
        result.sigma_px(v, u) = known ? kSigmaPx : kUnknown;
      }
    }
    return result;
  }

 private:
  DisparityConfig config_;
  cv::Ptr<cv::StereoSGBM> sgbm_;
  cv::Mat left_, right_, sixteenths_;
};

DisparityMatcher::DisparityMatcher(const DisparityConfig& config) {
  std::string all;
  for (const std::string& problem : config.Problems()) all += "stereo." + problem + "\n";
  if (!all.empty()) throw std::invalid_argument(all);
  impl_ = std::make_unique<Impl>(config);
}
DisparityMatcher::~DisparityMatcher() = default;

DisparityImage DisparityMatcher::Match(const StereoFrame& frame) {
  TERRACE_CHECK(!frame.left.empty() && frame.left.size() == frame.right.size(), frame.left.cols,
                frame.left.rows, frame.right.cols, frame.right.rows);
  return impl_->Match(frame);
}

}  // namespace terrace
