// SPDX-License-Identifier: BSD-3-Clause
#include "core/lens_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"

namespace terrace {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double Coefficient(const RawCamera& camera, std::size_t i) {
  return i < camera.distortion.size() ? camera.distortion[i] : 0.0;
}

/// OpenCV's tilted sensor: the plane of the image seen along the axis of the lens.
Eigen::Vector2d Tilt(const Eigen::Vector2d& m, double tau_x, double tau_y) {
  Eigen::Matrix3d R_x, R_y, onto_sensor;
  R_x << 1, 0, 0, 0, std::cos(tau_x), std::sin(tau_x), 0, -std::sin(tau_x), std::cos(tau_x);
  R_y << std::cos(tau_y), 0, -std::sin(tau_y), 0, 1, 0, std::sin(tau_y), 0, std::cos(tau_y);
  const Eigen::Matrix3d R = R_y * R_x;
  onto_sensor << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  return (onto_sensor * (R * m.homogeneous())).hnormalized();
}

/// k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tau_x tau_y]]]], from coefficient `first` on.
Eigen::Vector2d RadialTangential(const RawCamera& camera, std::size_t first, double x, double y) {
  const auto k = [&](std::size_t i) { return Coefficient(camera, first + i); };
  const std::size_t n = camera.distortion.size() - std::min(first, camera.distortion.size());
  const double r2 = x * x + y * y;
  double radial = 1.0 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)));
  if (n > 5) radial /= 1.0 + r2 * (k(5) + r2 * (k(6) + r2 * k(7)));
  Eigen::Vector2d m(x * radial + 2.0 * k(2) * x * y + k(3) * (r2 + 2.0 * x * x),
                    y * radial + k(2) * (r2 + 2.0 * y * y) + 2.0 * k(3) * x * y);
  if (n > 8) m += r2 * Eigen::Vector2d(k(8) + r2 * k(9), k(10) + r2 * k(11));
  return n > 12 ? Tilt(m, k(12), k(13)) : m;
}

Eigen::Vector2d Equidistant(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const auto k = [&](std::size_t i) { return Coefficient(camera, i); };
  const double r = std::hypot(ray.x(), ray.y());
  const double theta = std::atan2(r, ray.z());
  const double theta2 = theta * theta;
  const double theta_d = theta * (1.0 + theta2 * (k(0) + theta2 * (k(1) + theta2 * (k(2) + theta2 * k(3)))));
  const double scale = r > 1e-9 * std::abs(ray.z()) ? theta_d / r : 1.0 / ray.z();
  return {scale * ray.x(), scale * ray.y()};
}

Eigen::Vector2d Omni(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const double z = ray.z() + Coefficient(camera, 0) * ray.norm();
  if (z <= 0.0) return {kNaN, kNaN};
  return RadialTangential(camera, 1, ray.x() / z, ray.y() / z);
}

/// Usenko, Demmel, Cremers: The Double Sphere Camera Model, 3DV 2018, equations 40 to 45.
Eigen::Vector2d DoubleSphere(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const double xi = Coefficient(camera, 0);
  const double alpha = Coefficient(camera, 1);
  const double shifted_z = xi * ray.norm() + ray.z();
  const double d2 = std::hypot(ray.x(), ray.y(), shifted_z);
  const double z = alpha * d2 + (1.0 - alpha) * shifted_z;
  if (z <= 0.0) return {kNaN, kNaN};
  return ray.head<2>() / z;
}

/// Khomutenko, Garcia, Martinet: An Enhanced Unified Camera Model, RA-L 2016.
Eigen::Vector2d ExtendedUnified(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const double alpha = Coefficient(camera, 0);
  const double beta = Coefficient(camera, 1);
  const double d = std::sqrt(beta * ray.head<2>().squaredNorm() + ray.z() * ray.z());
  const double z = alpha * d + (1.0 - alpha) * ray.z();
  if (z <= 0.0) return {kNaN, kNaN};
  return ray.head<2>() / z;
}

/// Devernay, Faugeras: Straight lines have to be straight, 2001.
Eigen::Vector2d FieldOfView(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const double w = Coefficient(camera, 0);
  const double r = ray.head<2>().norm();
  const double stretch = 2.0 * std::tan(0.5 * w);
  const double scale =
      r > 1e-9 * std::abs(ray.z()) ? std::atan2(r * stretch, ray.z()) / (r * w) : stretch / (w * ray.z());
  return scale * ray.head<2>();
}

/// Scaramuzza's polynomial gives the ray of a pixel; the way back is the first rho whose ray has this angle.
Eigen::Vector2d Polynomial(const RawCamera& camera, const Eigen::Vector3d& ray) {
  const auto b = [&](std::size_t i) { return Coefficient(camera, i); };
  const double r = ray.head<2>().norm();
  if (r <= 1e-12 * std::abs(ray.z())) return Eigen::Vector2d::Zero();
  // g falls through zero where the polynomial's ray has the angle of this one; in units of the ray's length.
  const double sine = r / ray.norm();
  const double cosine = ray.z() / ray.norm();
  const auto g = [&](double rho) {
    return sine * (1.0 + rho * (b(0) + rho * (b(1) + rho * (b(2) + rho * b(3))))) - cosine * rho;
  };
  constexpr double kStep = 0.05;
  constexpr double kLargest = 10.0;
  double high = kStep;
  while (high < kLargest && g(high) > 0.0) high += kStep;
  if (high >= kLargest) return {kNaN, kNaN};
  double low = high - kStep;
  constexpr int kSecants = 60;  // Illinois: the bracket is kept, a few steps do
  double g_low = g(low), g_high = g(high);
  double rho = high;
  for (int i = 0; i < kSecants && high - low > 1e-15; ++i) {
    rho = high - g_high * (high - low) / (g_high - g_low);
    const double g_rho = g(rho);
    if (std::abs(g_rho) < 1e-15) break;
    if (g_rho > 0.0) {
      low = rho;
      g_low = g_rho;
      g_high *= 0.5;
    } else {
      high = rho;
      g_high = g_rho;
      g_low *= 0.5;
    }
  }
  const Eigen::Vector2d m = ray.head<2>() * (rho / r);
  return {m.x() + b(4) * m.y(), b(5) * m.x() + b(6) * m.y()};
}

constexpr std::array kModelNames = {"radial-tangential", "equidistant",   "omni",      "double-sphere",
                                    "extended-unified",  "field-of-view", "polynomial"};

}  // namespace

const char* Name(DistortionModel model) { return kModelNames.at(static_cast<std::size_t>(model)); }

std::optional<DistortionModel> DistortionModelFromName(const std::string& name) {
  const auto found = std::find(kModelNames.begin(), kModelNames.end(), name);
  if (found == kModelNames.end()) return std::nullopt;
  return static_cast<DistortionModel>(found - kModelNames.begin());
}

std::vector<std::size_t> CoefficientCounts(DistortionModel model) {
  switch (model) {
    case DistortionModel::kRadialTangential:
      return {0, 4, 5, 8, 12, 14};
    case DistortionModel::kEquidistant:
      return {0, 4};
    case DistortionModel::kOmni:
      return {5};
    case DistortionModel::kDoubleSphere:
    case DistortionModel::kExtendedUnified:
      return {2};
    case DistortionModel::kFieldOfView:
      return {1};
    case DistortionModel::kPolynomial:
      return {7};
  }
  TERRACE_CHECK(false, static_cast<int>(model));
}

Eigen::Vector2d ProjectByModel(const RawCamera& camera, const Eigen::Vector3d& ray) {
  switch (camera.model) {
    case DistortionModel::kRadialTangential:
      if (ray.z() <= 0.0) return {kNaN, kNaN};
      return RadialTangential(camera, 0, ray.x() / ray.z(), ray.y() / ray.z());
    case DistortionModel::kEquidistant:
      return Equidistant(camera, ray);
    case DistortionModel::kOmni:
      return Omni(camera, ray);
    case DistortionModel::kDoubleSphere:
      return DoubleSphere(camera, ray);
    case DistortionModel::kExtendedUnified:
      return ExtendedUnified(camera, ray);
    case DistortionModel::kFieldOfView:
      return FieldOfView(camera, ray);
    case DistortionModel::kPolynomial:
      return Polynomial(camera, ray);
  }
  TERRACE_CHECK(false, static_cast<int>(camera.model));
}

RawCamera WithoutAsymmetry(RawCamera camera) {
  std::vector<double>& k = camera.distortion;
  const auto clear = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < std::min(end, k.size()); ++i) k[i] = 0.0;
  };
  if (camera.model == DistortionModel::kRadialTangential) {
    clear(2, 4);
    clear(8, 14);
  } else if (camera.model == DistortionModel::kOmni) {
    clear(3, 5);
  } else if (camera.model == DistortionModel::kPolynomial && k.size() == 7) {
    clear(4, 6);
    k[6] = 1.0;
  }
  return camera;
}

}  // namespace terrace
