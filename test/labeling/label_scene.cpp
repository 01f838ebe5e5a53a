// SPDX-License-Identifier: BSD-3-Clause
#include "label_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace terrace {
namespace {

Eigen::Vector3d Turned(double yaw, double x, double y, double z = 0.0) {
  return {std::cos(yaw) * x - std::sin(yaw) * y, std::sin(yaw) * x + std::cos(yaw) * y, z};
}

/// The plane through a planar ring, by Newell's sums.
Plane PlaneOf(const Ring& ring) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    normal += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
    mean += ring[i] / static_cast<double>(ring.size());
  }
  normal.normalize();
  return {normal, normal.dot(mean)};
}

}  // namespace

void LabelScene::AddLevel(TerrainLabel label, const Eigen::Vector3d& center, double size_x, double size_y,
                          double yaw_rad) {
  KnownPiece piece;
  piece.label = label;
  for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
    piece.outline.push_back(center + Turned(yaw_rad, 0.5 * size_x * x, 0.5 * size_y * y));
  pieces.push_back(piece);
}

void LabelScene::AddFace(TerrainLabel label, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                         double height_m, int step_index) {
  const Eigen::Vector3d up(0, 0, height_m);
  pieces.push_back({{a, b, b + up, a + up}, {}, label, step_index});
}

void LabelScene::AddBox(const Eigen::Vector3d& foot_center, double size_x, double size_y, double height_m,
                        double yaw_rad, TerrainLabel top) {
  Ring corners;
  for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
    corners.push_back(foot_center + Turned(yaw_rad, 0.5 * size_x * x, 0.5 * size_y * y));
  for (int i = 0; i < 4; ++i) AddFace(TerrainLabel::kObstacle, corners[i], corners[(i + 1) % 4], height_m);
  AddLevel(top, foot_center + Eigen::Vector3d(0, 0, height_m), size_x, size_y, yaw_rad);
}

void LabelScene::AddFlight(const KnownFlight& f) {
  const auto at = [&](double along, double left, double z) {
    return Eigen::Vector3d(f.foot + Turned(f.yaw_rad, along, left, z));
  };
  const double half = 0.5 * f.width_m;
  for (int k = 1; k <= f.num_risers; ++k) {
    const double along = (k - 1) * f.run_m;
    if (!f.open_risers) {
      AddFace(TerrainLabel::kStairRiser, at(along, half, (k - 1) * f.rise_m),
              at(along, -half, (k - 1) * f.rise_m), f.rise_m, k);
    }
    if (k == f.num_risers) break;
    const double z = k * f.rise_m;
    const double front = along - f.nosing_m;
    pieces.push_back({{at(front, half, z), at(front, -half, z), at(along + f.run_m, -half, z),
                       at(along + f.run_m, half, z)},
                      {},
                      TerrainLabel::kStairTread,
                      k});
  }
}

void LabelScene::AddSpiral(const Eigen::Vector3d& axis_foot, double inner_radius_m, double outer_radius_m,
                           int num_risers, double rise_m, double turn_per_step_rad) {
  const auto at = [&](double angle, double radius, double z) {
    return Eigen::Vector3d(axis_foot + Turned(angle, radius, 0.0, z));
  };
  const bool left = turn_per_step_rad > 0.0;
  for (int k = 1; k <= num_risers; ++k) {
    const double angle = (k - 1) * turn_per_step_rad;
    const double z = (k - 1) * rise_m;
    const Eigen::Vector3d in = at(angle, inner_radius_m, z);
    const Eigen::Vector3d out = at(angle, outer_radius_m, z);
    AddFace(TerrainLabel::kStairRiser, left ? in : out, left ? out : in, rise_m, k);
    if (k == num_risers) break;
    Ring tread{at(angle, inner_radius_m, z + rise_m), at(angle, outer_radius_m, z + rise_m),
               at(angle + turn_per_step_rad, outer_radius_m, z + rise_m),
               at(angle + turn_per_step_rad, inner_radius_m, z + rise_m)};
    if (!left) std::reverse(tread.begin(), tread.end());
    pieces.push_back({tread, {}, TerrainLabel::kStairTread, k});
  }
}

PolygonUpdate LabelScene::Update(const Noise& noise, unsigned seed) const {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  // Two statements, because the order of evaluation within one is the compiler's.
  const auto within_plane = [&](const PlaneAxes& axes) -> Eigen::Vector3d {
    const double y = normal(generator);
    const double x = normal(generator);
    return x * axes.x + y * axes.y;
  };
  PolygonUpdate update;
  update.t_capture = {1'000'000'000};
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    auto polygon = std::make_shared<Polygon>();
    polygon->id = static_cast<PolygonId>(i) + 1;
    polygon->revision = 1;
    const Plane truth = PlaneOf(pieces[i].outline);
    const PlaneAxes axes = AxesOf(truth.normal);
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : pieces[i].outline)
      center += p / static_cast<double>(pieces[i].outline.size());
    // The larger a piece, the better its plane is known.
    constexpr double kSize = 0.5;
    double radius = 0.5 * kSize;
    for (const Eigen::Vector3d& p : pieces[i].outline) radius = std::max(radius, (p - center).norm());
    const double tilt_rad = noise.tilt_rad * 0.5 * kSize / radius;
    const Eigen::Vector3d tilted = (truth.normal + tilt_rad * within_plane(axes)).normalized();
    polygon->plane_world = {tilted, tilted.dot(center) + noise.offset_m * normal(generator)};
    const auto spoilt = [&](const Ring& ring) {
      Ring result;
      for (const Eigen::Vector3d& p : ring) {
        result.push_back(polygon->plane_world.Project(p + noise.edge_m * within_plane(axes)));
      }
      return result;
    };
    polygon->outline_world = spoilt(pieces[i].outline);
    for (const Ring& hole : pieces[i].holes) polygon->holes_world.push_back(spoilt(hole));
    polygon->area_m2 = SignedArea(polygon->outline_world, tilted);
    for (const Ring& hole : polygon->holes_world) polygon->area_m2 += SignedArea(hole, tilted);
    polygon->centroid_world = polygon->plane_world.Project(center);
    polygon->plane_covariance.diagonal().setConstant(tilt_rad * tilt_rad + 1e-6);
    polygon->rms_m = 0.003;
    polygon->support = 1.0;
    polygon->num_observations = 10;
    polygon->first_seen = polygon->last_seen = update.t_capture;
    update.changed.push_back(polygon);
    update.added.push_back(polygon->id);
  }
  constexpr PolygonId kMostPieces = 200;
  for (PolygonId id = static_cast<PolygonId>(pieces.size()) + 1; id <= kMostPieces; ++id)
    update.removed.push_back(id);
  return update;
}

Eigen::Isometry3d TestBodyLeft() {
  constexpr double kPitch = 20.0 * std::numbers::pi / 180.0;
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  T_body_left.linear().col(0) = Eigen::Vector3d(0, -1, 0);
  T_body_left.linear().col(1) = Eigen::Vector3d(-std::sin(kPitch), 0, -std::cos(kPitch));
  T_body_left.linear().col(2) = Eigen::Vector3d(std::cos(kPitch), 0, -std::sin(kPitch));
  T_body_left.translation() = Eigen::Vector3d(0.22, 0.06, 0.09);
  return T_body_left;
}

PoseEstimate StandingAt(double x, double y, double ground_z, double yaw_rad) {
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.translation() = Eigen::Vector3d(x, y, ground_z + RobotConfig{}.body_height_m);
  T_world_body.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  PoseEstimate pose;
  pose.status = TrackingStatus::kTracking;
  pose.t_capture = {1'000'000'000};
  pose.T_world_left = T_world_body * TestBodyLeft();
  return pose;
}

StereoCamera TestCamera() { return {640, 480, 400.0, 400.0, 319.5, 239.5, 0.12}; }

Gravity TestGravity() {
  Gravity gravity;
  gravity.source = GravitySource::kImu;
  return gravity;
}

TerrainLabeler MakeLabeler() {
  return TerrainLabeler(LabelingConfig{}, StaircaseConfig{}, RobotConfig{}, TestCamera(), TestBodyLeft());
}

TerrainMapPtr LabelOften(TerrainLabeler& labeler, const PolygonUpdate& update, const PoseEstimate& pose,
                         int times) {
  for (int i = 0; i < times; ++i) labeler.Label(update, pose, TestGravity());
  return labeler.map();
}

std::string WrongLabels(const LabelScene& scene, const TerrainMap& map) {
  std::ostringstream wrong;
  for (const auto& region : map.regions) {
    if (region->predicted()) continue;  // is no piece of the scene
    const KnownPiece& piece = scene.pieces.at(static_cast<std::size_t>(region->id) - 1);
    const int step = region->step_index.value_or(0);
    if (region->label == piece.label && step == piece.step_index) continue;
    wrong << "piece " << region->id << " at " << piece.outline[0].transpose() << " is a " << Name(piece.label)
          << ' ' << piece.step_index << ", labelled " << Name(region->label) << ' ' << step << '\n';
  }
  return wrong.str();
}

}  // namespace terrace
