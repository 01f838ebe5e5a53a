// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_directions.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/angles.h"

namespace terrace {
namespace {

/// Where two lines of the plan meet; none when they are nearly parallel.
std::optional<Eigen::Vector2d> Meeting(const Eigen::Vector2d& p, const Eigen::Vector2d& u,
                                       const Eigen::Vector2d& q, const Eigen::Vector2d& v) {
  const double minimum = std::sin(Radians(7.0));
  const double sine = Cross(u, v);
  if (std::abs(sine) < minimum) return std::nullopt;
  return p + u * (Cross(q - p, v) / sine);
}

/// An axis on which the planes of two risers, or the sides of a tread, agree.
struct Axis {
  Eigen::Vector2d point;
  double radius_m = 0.0;
};

class AxisList {
 public:
  void Add(const Eigen::Vector2d& point, double radius_m) {
    constexpr double kMinRadius = 0.3;
    constexpr double kMaxRadius = 3.0;
    constexpr double kSameAxis = 0.15;
    constexpr std::size_t kMaxAxes = 12;
    if (radius_m < kMinRadius || radius_m > kMaxRadius || axes_.size() >= kMaxAxes) return;
    for (const Axis& known : axes_)
      if ((known.point - point).norm() < kSameAxis && std::abs(known.radius_m - radius_m) < kSameAxis) return;
    axes_.push_back({point, radius_m});
  }
  const std::vector<Axis>& axes() const { return axes_; }

 private:
  std::vector<Axis> axes_;
};

/// The planes of the risers pass through the axis: neighbours in height tell where.
void AddAxesOfRisers(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                     const std::vector<StepCandidate>& candidates, AxisList& axes) {
  for (const StepCandidate& a : candidates) {
    for (const StepCandidate& b : candidates) {
      if (!a.riser || !b.riser || a.leaning || b.leaning) continue;
      const RegionShape& low = *shapes[a.shape];
      const RegionShape& high = *shapes[b.shape];
      const double rise = high.face_heights.middle() - low.face_heights.middle();
      if (rise < config.min_riser_m || rise > config.max_riser_m) continue;
      const Eigen::Vector2d p = low.rectangle.center;
      const Eigen::Vector2d q = high.rectangle.center;
      if ((q - p).norm() > 2.0 * config.max_tread_m || low.front().dot(high.front()) < 0.5) continue;
      if (const auto axis = Meeting(p, low.face_axis, q, high.face_axis))
        axes.Add(*axis, 0.5 * ((p - *axis).norm() + (q - *axis).norm()));
    }
  }
}

/// The two long sides of a tread meet at the axis as well: that is all there is from above.
void AddAxesOfTreads(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                     const std::vector<StepCandidate>& candidates, AxisList& axes) {
  for (const StepCandidate& c : candidates) {
    if (c.riser || c.landing) continue;
    const PlanRing& ring = shapes[c.shape]->plan.front();
    std::vector<std::pair<double, std::size_t>> sides;  // minus length, index
    for (std::size_t i = 0; i < ring.size(); ++i)
      sides.emplace_back(-(ring[(i + 1) % ring.size()] - ring[i]).norm(), i);
    std::sort(sides.begin(), sides.end());
    const auto side = [&](int n) {
      return ring[(sides[n].second + 1) % ring.size()] - ring[sides[n].second];
    };
    if (sides.size() < 3 || -sides[1].first < config.min_width_m) continue;
    if (const auto axis =
            Meeting(ring[sides[0].second], side(0).normalized(), ring[sides[1].second], side(1).normalized()))
      axes.Add(*axis, (shapes[c.shape]->rectangle.center - *axis).norm());
  }
}

}  // namespace

std::vector<FlightFramePtr> StraightFrames(const StaircaseConfig& config,
                                           const std::vector<RegionShapePtr>& shapes,
                                           const std::vector<StepCandidate>& candidates) {
  struct Vote {
    Eigen::Vector2d direction;
    double weight;
  };
  std::vector<Vote> votes;
  for (const StepCandidate& c : candidates) {
    const RegionShape& s = *shapes[c.shape];
    if (c.riser || c.leaning) {
      votes.push_back({-s.plane.normal.head<2>().normalized(), s.area_m2});
    } else if (!c.spiral_only && s.rectangle.length_m > 1.5 * s.rectangle.depth_m) {
      const double weight = s.rectangle.Elongation() * s.area_m2;
      votes.push_back({s.rectangle.short_axis(), weight});
      votes.push_back({-s.rectangle.short_axis(), weight});
    }
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.weight > b.weight; });
  constexpr std::size_t kMaxFrames = 12;
  const double same = std::cos(Radians(0.5 * config.max_turn_deg));
  std::vector<Eigen::Vector2d> sums;
  for (const Vote& vote : votes) {
    const auto cluster = std::find_if(sums.begin(), sums.end(), [&](const Eigen::Vector2d& sum) {
      return sum.normalized().dot(vote.direction) >= same;
    });
    if (cluster != sums.end())
      *cluster += vote.weight * vote.direction;
    else if (sums.size() < kMaxFrames)
      sums.push_back(vote.weight * vote.direction);
  }
  std::vector<FlightFramePtr> frames;
  for (const Eigen::Vector2d& sum : sums) frames.push_back(std::make_shared<StraightFrame>(sum.normalized()));
  return frames;
}

std::vector<FlightFramePtr> SpiralFrames(const StaircaseConfig& config,
                                         const std::vector<RegionShapePtr>& shapes,
                                         const std::vector<StepCandidate>& candidates) {
  AxisList axes;
  AddAxesOfRisers(config, shapes, candidates, axes);
  AddAxesOfTreads(config, shapes, candidates, axes);
  std::vector<FlightFramePtr> frames;
  for (const Axis& axis : axes.axes())
    for (const double turn_sign : {1.0, -1.0})
      frames.push_back(std::make_shared<SpiralFrame>(axis.point, axis.radius_m, turn_sign));
  return frames;
}

}  // namespace terrace
