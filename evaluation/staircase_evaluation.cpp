// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/staircase_evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "core/angles.h"
#include "core/plane_rings.h"
#include "evaluation/planar_shape.h"

namespace terrace {
namespace {

/// A reported staircase is the true one when its foot or its head lies this near to it, and it climbs within
/// this angle of it.
constexpr double kMatchDistance_m = 0.3;
constexpr double kMatchAngle_deg = 30.0;
/// A true staircase whose edges differ by more turns; its direction then depends on where one stands.
constexpr double kTurningAngle_deg = 10.0;
/// What is right.
constexpr double kRightRiser_m = 0.02;
constexpr double kRightTread_m = 0.04;
constexpr double kRightDirection_deg = 10.0;

double HorizontalAngle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector2d p = a.head<2>().normalized();
  const Eigen::Vector2d q = b.head<2>().normalized();
  return Degrees(std::acos(std::clamp(p.dot(q), -1.0, 1.0)));
}

/// Horizontal distance of a point from a segment.
double HorizontalDistance(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 2>& edge) {
  const Eigen::Vector2d a = edge[0].head<2>(), b = edge[1].head<2>(), q = p.head<2>();
  return (NearestOnSegment(a, b, q) - q).norm();
}

/// A true staircase with the polygons it consists of.
struct TrueFlight {
  const TrueStaircase* staircase;
  std::vector<PlanarShape> shapes;
  int num_seen = 0;  ///< polygons of it that some frame saw

  bool turning() const {
    const Eigen::Vector3d foot = staircase->foot_edge_world[1] - staircase->foot_edge_world[0];
    const Eigen::Vector3d head = staircase->head_edge_world[1] - staircase->head_edge_world[0];
    return HorizontalAngle_deg(foot, head) > kTurningAngle_deg;
  }
  double DistanceTo(const Eigen::Vector3d& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const PlanarShape& shape : shapes) {
      const double height = shape.plane().SignedDistance(p);
      const double aside = shape.LiesOver(p) ? 0.0 : shape.DistanceToEdge(p);
      least = std::min(least, std::hypot(height, aside));
    }
    return least;
  }
};

std::vector<TrueFlight> FlightsOf(const TrueScene& truth) {
  std::vector<TrueFlight> flights;
  for (const TrueStaircase& staircase : truth.staircases) {
    TrueFlight flight{&staircase, {}, 0};
    const std::set<int> ids(staircase.polygon_ids.begin(), staircase.polygon_ids.end());
    for (const TruePolygon& polygon : truth.polygons) {
      if (!ids.contains(polygon.id)) continue;
      flight.shapes.emplace_back(polygon.plane_world, polygon.outline_world, polygon.holes_world);
      const auto& seen = polygon.observed.seen;
      flight.num_seen += std::find(seen.begin(), seen.end(), 1) != seen.end();
    }
    if (flight.num_seen >= 2) flights.push_back(std::move(flight));
  }
  return flights;
}

/// A staircase of the result, moved onto the truth.
Staircase Moved(const Eigen::Isometry3d& T, const Staircase& staircase) {
  Staircase moved = staircase;
  for (auto* edge : {&moved.foot_edge_world, &moved.head_edge_world}) {
    for (Eigen::Vector3d& p : *edge) p = T * p;
  }
  Eigen::Vector3d direction = T.linear() * staircase.direction_up_world;
  direction.z() = 0.0;
  moved.direction_up_world = direction.normalized();
  return moved;
}

bool Matches(const Staircase& staircase, const TrueFlight& flight) {
  const Eigen::Vector3d head = 0.5 * (staircase.head_edge_world[0] + staircase.head_edge_world[1]);
  if (flight.DistanceTo(staircase.base_world()) > kMatchDistance_m &&
      flight.DistanceTo(head) > kMatchDistance_m) {
    return false;
  }
  return flight.turning() || HorizontalAngle_deg(staircase.direction_up_world,
                                                 flight.staircase->direction_up_world) <= kMatchAngle_deg;
}

bool Right(const Staircase& staircase, const TrueFlight& flight) {
  const TrueStaircase& truth = *flight.staircase;
  return staircase.num_risers == truth.num_risers &&
         std::abs(staircase.riser_m - truth.riser_m) <= kRightRiser_m &&
         std::abs(staircase.tread_m - truth.tread_m) <= kRightTread_m &&
         (flight.turning() ||
          HorizontalAngle_deg(staircase.direction_up_world, truth.direction_up_world) <= kRightDirection_deg);
}

std::optional<double> DistanceAt(Timestamp t, const TrueFlight& flight,
                                 const std::vector<TimedPose>& true_left) {
  const auto next = std::lower_bound(true_left.begin(), true_left.end(), t,
                                     [](const TimedPose& pose, Timestamp time) { return pose.t < time; });
  if (next == true_left.end()) return std::nullopt;
  const Eigen::Vector3d p = next->T_world_frame.translation();
  return std::min(HorizontalDistance(p, flight.staircase->foot_edge_world),
                  HorizontalDistance(p, flight.staircase->head_edge_world));
}

void Compare(const Staircase& found, const TrueStaircase& truth, StaircaseMatch* match) {
  match->result_id = found.id;
  match->num_risers_error = found.num_risers - truth.num_risers;
  match->riser_error_m = found.riser_m - truth.riser_m;
  match->tread_error_m = found.tread_m - truth.tread_m;
  match->width_error_m = found.width_m - truth.width_m;
  match->direction_error_deg = HorizontalAngle_deg(found.direction_up_world, truth.direction_up_world);
  const Eigen::Vector3d true_base = 0.5 * (truth.foot_edge_world[0] + truth.foot_edge_world[1]);
  match->base_error_m = (found.base_world() - true_base).head<2>().norm();
}

}  // namespace

StaircaseEvaluation EvaluateStaircases(const std::vector<Staircase>& staircases,
                                       const std::vector<StaircaseReport>& reports, const TrueScene& truth,
                                       const Eigen::Isometry3d& T_true_result,
                                       const std::vector<TimedPose>& true_left) {
  StaircaseEvaluation evaluation;
  const std::vector<TrueFlight> flights = FlightsOf(truth);
  evaluation.num_true = static_cast<int>(flights.size());
  evaluation.num_result = static_cast<int>(staircases.size());
  std::set<std::int64_t> taken;
  for (const TrueFlight& flight : flights) {
    StaircaseMatch match;
    match.true_id = flight.staircase->id;
    match.num_risers_true = flight.staircase->num_risers;
    // Of several at one place the one with the most nearly right count is it; the others are false.
    std::optional<Staircase> best;
    for (const Staircase& staircase : staircases) {
      const Staircase moved = Moved(T_true_result, staircase);
      if (taken.contains(moved.id) || !Matches(moved, flight)) continue;
      const auto off = [&](const Staircase& s) { return std::abs(s.num_risers - match.num_risers_true); };
      if (!best || off(moved) < off(*best)) best = moved;
    }
    if (best) {
      taken.insert(best->id);
      ++evaluation.num_found;
      Compare(*best, *flight.staircase, &match);
    }
    for (const StaircaseReport& report : reports) {
      const Staircase moved = Moved(T_true_result, report.staircase);
      if (!Matches(moved, flight)) continue;
      if (!match.first_reported_m) match.first_reported_m = DistanceAt(report.t_capture, flight, true_left);
      if (!match.first_right_m && Right(moved, flight)) {
        match.first_right_m = DistanceAt(report.t_capture, flight, true_left);
      }
    }
    evaluation.matches.push_back(match);
  }
  evaluation.precision =
      staircases.empty() ? 1.0 : static_cast<double>(evaluation.num_found) / evaluation.num_result;
  evaluation.recall = flights.empty() ? 1.0 : static_cast<double>(evaluation.num_found) / evaluation.num_true;
  return evaluation;
}

}  // namespace terrace
