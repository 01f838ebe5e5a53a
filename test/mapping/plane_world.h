// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "stereo/cloud.h"

namespace terrace {

/// A world of rectangles that a stereo camera looks at: clouds with known truth and realistic noise for the
/// tests.
struct PlaneWorld {
  /// Corner, and the two edges from it; seen from where edge_x cross edge_y points.
  struct Rectangle {
    Eigen::Vector3d corner, edge_x, edge_y;

    Eigen::Vector3d normal() const { return edge_x.cross(edge_y).normalized(); }
    double area_m2() const { return edge_x.cross(edge_y).norm(); }
  };
  std::vector<Rectangle> rectangles;

  void AddFloor(double x0, double x1, double y0, double y1, double z) {
    rectangles.push_back({{x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}});
  }
  /// An upright face at x, seen from smaller x.
  void AddFaceTowardsMinusX(double x, double y0, double y1, double z0, double z1) {
    rectangles.push_back({{x, y0, z0}, {0, 0, z1 - z0}, {0, y1 - y0, 0}});
  }
  void AddBox(double x0, double x1, double y0, double y1, double z0, double z1) {
    AddFloor(x0, x1, y0, y1, z1);
    AddFaceTowardsMinusX(x0, y0, y1, z0, z1);
    rectangles.push_back({{x1, y0, z0}, {0, y1 - y0, 0}, {0, 0, z1 - z0}});
    rectangles.push_back({{x0, y0, z0}, {x1 - x0, 0, 0}, {0, 0, z1 - z0}});
    rectangles.push_back({{x0, y1, z0}, {0, 0, z1 - z0}, {x1 - x0, 0, 0}});
  }
  /// Risers first: riser 1 stands at x; the last tread is as deep as the others.
  void AddStairs(double x, double y0, double y1, double rise, double run, int num) {
    for (int i = 0; i < num; ++i) {
      AddFaceTowardsMinusX(x + i * run, y0, y1, i * rise, (i + 1) * rise);
      AddFloor(x + i * run, x + (i + 1) * run, y0, y1, (i + 1) * rise);
    }
  }

  /// What a camera sees, every `step`-th pixel and no more than half of all, like Triangulate(); disparities
  /// carry Gaussian noise.
  Cloud See(const StereoCamera& camera, const Eigen::Isometry3d& T_world_left, FrameId frame_id, int step,
            double sigma_px, std::mt19937* random) const {
    Cloud cloud;
    cloud.frame_id = frame_id;
    cloud.t_capture = {1'000'000'000 + frame_id * 50'000'000};
    std::normal_distribution<double> noise(0.0, sigma_px);
    for (int v = 0; v < camera.height; v += step) {
      for (int u = 0; u < camera.width; u += step) {
        const Eigen::Vector3d ray_left((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        const double depth = Depth(T_world_left.translation(), T_world_left.linear() * ray_left);
        if (!std::isfinite(depth)) continue;
        const double disparity = camera.Disparity(depth) + (sigma_px > 0.0 ? noise(*random) : 0.0);
        if (disparity < 1.0) continue;
        const Eigen::Vector3d p = camera.Triangulate(u, v, disparity);
        const double sigma = camera.DepthSigma(p.z(), std::max(sigma_px, 0.02));
        if (sigma > 0.05 || ((u ^ v) & 1) != 0) continue;
        cloud.points.push_back({p.cast<float>(), static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(v),
                                static_cast<float>(sigma)});
      }
    }
    return cloud;
  }

  /// Distance along the ray in units of its length; infinite when it meets nothing.
  double Depth(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Rectangle& r : rectangles) {
      const Eigen::Vector3d n = r.normal();
      const double slope = n.dot(ray);
      if (slope > -1e-9) continue;
      const double t = n.dot(r.corner - from) / slope;
      if (t <= 0.05 || t >= nearest) continue;
      const Eigen::Vector3d d = from + t * ray - r.corner;
      const double a = d.dot(r.edge_x) / r.edge_x.squaredNorm(), b = d.dot(r.edge_y) / r.edge_y.squaredNorm();
      if (a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0) nearest = t;
    }
    return nearest;
  }
};

inline StereoCamera TestCamera() { return {320, 240, 200.0, 200.0, 159.5, 119.5, 0.12}; }

/// A camera above the ground at (x, y, height), looking along `yaw` and down by `pitch`.
inline PoseEstimate LookFrom(FrameId frame_id, double x, double y, double height, double yaw_rad,
                             double pitch_rad) {
  PoseEstimate pose;
  pose.frame_id = frame_id;
  pose.status = TrackingStatus::kTracking;
  pose.trusted = true;
  Eigen::Matrix3d R_body_left;
  R_body_left << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  pose.T_world_left.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                               Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()).toRotationMatrix() *
                               R_body_left;
  pose.T_world_left.translation() << x, y, height;
  return pose;
}

}  // namespace terrace
