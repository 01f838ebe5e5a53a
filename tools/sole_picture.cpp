// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sole_picture.h"

#include <cmath>
#include <optional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/geometry.h"

namespace terrace {
namespace {

const cv::Scalar kLeftSole(32, 32, 192);
const cv::Scalar kRightSole(192, 64, 32);
const cv::Scalar kStepLine(255, 255, 255);
constexpr int kFineShift = 4;  // points are given to OpenCV in 1/16 px

Eigen::Vector3d VectorOf(const std::vector<double>& values) { return {values[0], values[1], values[2]}; }

cv::Point FinePoint(const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d fine = pixel * (1 << kFineShift);
  return {static_cast<int>(std::lround(fine.x())), static_cast<int>(std::lround(fine.y()))};
}

/// The border of a sole in the image; empty: it is not in front of the eye.
std::vector<cv::Point> BorderOf(const Eigen::Vector3d& p_world, const Eigen::Vector3d& normal_world,
                                double radius_m, const Projection& projection) {
  constexpr int kNumPoints = 24;
  const PlaneAxes axes = AxesOf(normal_world);
  std::vector<cv::Point> border;
  for (int i = 0; i < kNumPoints; ++i) {
    const double angle = 2.0 * M_PI * i / kNumPoints;
    const Eigen::Vector3d p = p_world + radius_m * (std::cos(angle) * axes.x + std::sin(angle) * axes.y);
    if (!projection.InFront(p)) return {};
    border.push_back(FinePoint(projection.Pixel(p)));
  }
  return border;
}

}  // namespace

void DrawSoles(cv::Mat3b& image, const Projection& projection, const footstep_plan_v1_t& plan,
               const std::function<bool(const cv::Point& pixel, std::int64_t region_id)>& shows) {
  std::optional<cv::Point> before;
  for (std::size_t i = 0; i < plan.pos.size(); ++i) {
    const Eigen::Vector3d p = VectorOf(plan.pos[i]);
    const std::vector<cv::Point> border =
        BorderOf(p, VectorOf(plan.normal[i]).normalized(), plan.foot_radius, projection);
    if (border.empty()) {
      before.reset();
      continue;
    }
    const cv::Point middle = FinePoint(projection.Pixel(p));
    if (before) cv::line(image, *before, middle, kStepLine, 1, cv::LINE_AA, kFineShift);
    before = middle;
    const cv::Scalar& colour = plan.side[i] == footstep_plan_v1_t::LEFT ? kLeftSole : kRightSole;
    const cv::Point pixel(middle.x >> kFineShift, middle.y >> kFineShift);
    if (cv::Rect({}, image.size()).contains(pixel) && shows(pixel, plan.region_id[i]))
      cv::fillPoly(image, std::vector{border}, colour, cv::LINE_AA, kFineShift);
    cv::polylines(image, border, true, colour, 1, cv::LINE_AA, kFineShift);
  }
}

}  // namespace terrace
