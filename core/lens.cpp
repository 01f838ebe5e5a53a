// SPDX-License-Identifier: BSD-3-Clause
#include "core/lens.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/lens_models.h"

namespace terrace {
namespace {

constexpr double kDegree = M_PI / 180.0;

Eigen::Vector3d RayAt(double angle_rad) { return {std::sin(angle_rad), 0.0, std::cos(angle_rad)}; }

/// The largest angle up to which the distance from the centre rises.
double LargestTrueAngle(const RawCamera& symmetric) {
  constexpr double kStep = 0.25 * kDegree;
  constexpr double kLargestPinhole = 87.0 * kDegree;
  constexpr double kLargest = 179.0 * kDegree;
  const bool pinhole = symmetric.model == DistortionModel::kRadialTangential;
  double previous = 0.0;
  double angle = kStep;
  for (; angle < (pinhole ? kLargestPinhole : kLargest); angle += kStep) {
    const double here = ProjectByModel(symmetric, RayAt(angle)).x();
    if (!(here > previous)) return angle - kStep;
    previous = here;
  }
  return angle - kStep;
}

std::string Number(double value) {
  std::ostringstream text;
  text.precision(6);
  text << value;
  return text.str();
}

std::string Counts(DistortionModel model) {
  const std::vector<std::size_t> counts = CoefficientCounts(model);
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == counts.size() ? " or " : ", ") + std::to_string(counts[i]);
  }
  return text;
}

/// What the coefficients of one model alone cannot be.
std::string CoefficientProblem(const RawCamera& camera) {
  const std::vector<double>& k = camera.distortion;
  for (const double value : k) {
    if (!std::isfinite(value)) return "a distortion coefficient is not a finite number";
  }
  const std::vector<std::size_t> counts = CoefficientCounts(camera.model);
  if (std::find(counts.begin(), counts.end(), k.size()) == counts.end()) {
    return std::to_string(k.size()) + " distortion coefficients, the " + Name(camera.model) +
           " model takes " + Counts(camera.model);
  }
  switch (camera.model) {
    case DistortionModel::kOmni:
      if (k[0] <= -1.0) return "xi = " + Number(k[0]) + " must be larger than -1";
      break;
    case DistortionModel::kDoubleSphere:
      if (k[0] <= -1.0 || k[0] > 1.0) return "xi = " + Number(k[0]) + " must lie between -1 and 1";
      if (k[1] < 0.0 || k[1] > 1.0) return "alpha = " + Number(k[1]) + " must lie between 0 and 1";
      break;
    case DistortionModel::kExtendedUnified:
      if (k[0] < 0.0 || k[0] > 1.0) return "alpha = " + Number(k[0]) + " must lie between 0 and 1";
      if (k[1] <= 0.0) return "beta = " + Number(k[1]) + " must be positive";
      break;
    case DistortionModel::kFieldOfView:
      if (k[0] <= 0.0 || k[0] >= M_PI) return "w = " + Number(k[0]) + " rad must lie between 0 and pi";
      break;
    default:
      break;
  }
  return "";
}

/// What the model as a whole does to the image that no lens does.
std::string ShapeProblem(const RawCamera& camera, int width, int height) {
  const RawCamera symmetric = WithoutAsymmetry(camera);
  const double focal_px = 0.5 * (camera.fx + camera.fy);
  const double max_angle_rad = LargestTrueAngle(symmetric);
  const double corner = 0.5 * std::hypot(width, height) / focal_px;
  const double slope = ProjectByModel(symmetric, RayAt(1e-4)).x() / std::tan(1e-4);
  // Pincushion lenses stretch their corners by some percent.
  constexpr double kLargestStretch = 1.25;
  for (double angle = kDegree; angle < std::min(max_angle_rad, 80.0 * kDegree); angle += kDegree) {
    const double radius = ProjectByModel(symmetric, RayAt(angle)).x();
    if (radius > corner) break;
    const double stretch = radius / (slope * std::tan(angle));
    if (stretch <= kLargestStretch) continue;
    return "at " + Number(angle / kDegree) + " deg from the axis these coefficients spread rays " +
           Number(stretch) +
           " times as far as a pinhole does, which no lens does: they belong to another "
           "model than " +
           Name(camera.model) + " (the first four of the 8 or 14 of a rational model look like this)";
  }
  // Corners may lie beyond what a fit knows; the middle may not.
  const double reach_px = ProjectByModel(symmetric, RayAt(max_angle_rad)).x() * focal_px;
  if (reach_px < 0.25 * std::min(width, height)) {
    return "the lens model turns back at " + Number(max_angle_rad / kDegree) + " deg from the axis, " +
           Number(reach_px) + " px from the centre: the image is larger";
  }
  return "";
}

}  // namespace

Lens::Lens(const RawCamera& camera)
    : camera_(camera),
      symmetric_(WithoutAsymmetry(camera)),
      max_angle_rad_(LargestTrueAngle(symmetric_)),
      cos_max_angle_(std::cos(max_angle_rad_)) {}

double Lens::Radius(double angle_rad) const { return ProjectByModel(symmetric_, RayAt(angle_rad)).x(); }

Eigen::Vector2d Lens::focal_px() const {
  constexpr double kTiny = 1e-4;
  const double slope = Radius(kTiny) / std::tan(kTiny);
  return {camera_.fx * slope, camera_.fy * slope};
}

std::optional<Eigen::Vector2d> Lens::Project(const Eigen::Vector3d& ray) const {
  if (ray.z() < cos_max_angle_ * ray.norm()) return std::nullopt;
  const Eigen::Vector2d m = ProjectByModel(camera_, ray);
  if (!m.allFinite()) return std::nullopt;
  return Eigen::Vector2d(camera_.fx * m.x() + camera_.cx, camera_.fy * m.y() + camera_.cy);
}

std::optional<double> Lens::AngleOf(double radius) const {
  double low = 0.0, high = max_angle_rad_;
  if (radius > Radius(high)) return std::nullopt;
  constexpr int kBisections = 30;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (Radius(middle) < radius ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::optional<Eigen::Vector3d> Lens::Unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d wanted((pixel.x() - camera_.cx) / camera_.fx, (pixel.y() - camera_.cy) / camera_.fy);
  const std::optional<double> angle = AngleOf(wanted.norm());
  if (!angle) return std::nullopt;
  const double around = std::atan2(wanted.y(), wanted.x());
  Eigen::Vector3d ray(std::sin(*angle) * std::cos(around), std::sin(*angle) * std::sin(around),
                      std::cos(*angle));
  // The symmetric part is right; Newton's steps on the unit sphere find the rest.
  constexpr int kSteps = 20;
  constexpr double kTiny = 1e-6;
  constexpr double kGoodEnough = 1e-12;
  double error = 1.0;
  for (int i = 0; i < kSteps && error > kGoodEnough; ++i) {
    const Eigen::Vector3d e1 = ray.unitOrthogonal();
    const Eigen::Vector3d e2 = ray.cross(e1);
    const Eigen::Vector2d residual = wanted - ProjectByModel(camera_, ray);
    error = residual.norm();
    if (!std::isfinite(error)) return std::nullopt;
    Eigen::Matrix2d J;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d step = kTiny * (axis == 0 ? e1 : e2);
      J.col(axis) =
          (ProjectByModel(camera_, ray + step) - ProjectByModel(camera_, ray - step)) / (2.0 * kTiny);
    }
    const Eigen::Vector2d move = J.inverse() * residual;
    if (!move.allFinite()) return std::nullopt;
    ray = (ray + move.x() * e1 + move.y() * e2).normalized();
  }
  constexpr double kFound = 1e-8;
  if (!(error < kFound) || ray.z() < cos_max_angle_) return std::nullopt;
  return ray;
}

std::vector<std::string> LensProblems(const RawCamera& camera, int width, int height) {
  std::vector<std::string> problems;
  const std::string coefficients = CoefficientProblem(camera);
  if (!coefficients.empty()) problems.push_back(coefficients);
  const double largest = std::max(width, height);
  const Eigen::Vector2d focal_px =
      coefficients.empty() ? Lens(camera).focal_px() : Eigen::Vector2d(camera.fx, camera.fy);
  bool scale_is_good = true;
  for (int axis = 0; axis < 2; ++axis) {
    // 0.1 image widths is a view of 157 deg of a pinhole, 20 is one of 3 deg: nobody walks with either.
    if (focal_px[axis] >= 0.1 * largest && focal_px[axis] <= 20.0 * largest) continue;
    scale_is_good = false;
    problems.push_back(std::string(axis == 0 ? "fx = " : "fy = ") +
                       Number(axis == 0 ? camera.fx : camera.fy) + " px is outside the image's scale (" +
                       Number(0.1 * largest) + " to " + Number(20.0 * largest) + ")");
  }
  if (camera.fx > 0 && camera.fy > 0 && !(camera.fx / camera.fy > 0.5 && camera.fx / camera.fy < 2.0)) {
    problems.push_back("fx / fy = " + Number(camera.fx / camera.fy) + ", must lie between 0.5 and 2");
  }
  if (!(camera.cx > -0.5 * width && camera.cx < 1.5 * width)) {
    problems.push_back("cx = " + Number(camera.cx) + " lies far outside the image of width " + Number(width));
  }
  if (!(camera.cy > -0.5 * height && camera.cy < 1.5 * height)) {
    problems.push_back("cy = " + Number(camera.cy) + " lies far outside the image of height " +
                       Number(height));
  }
  if (coefficients.empty() && scale_is_good) {
    const std::string shape = ShapeProblem(camera, width, height);
    if (!shape.empty()) problems.push_back(shape);
  }
  return problems;
}

}  // namespace terrace
