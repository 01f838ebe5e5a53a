// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/trajectory.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

constexpr double kPi = std::numbers::pi;
/// Spacing of the spline's controls: finer than the jolts (9 Hz).
constexpr double kStep_s = 0.02;

// The gait: both tripods together strike twice a second. Turn rates and accelerations come to 0.4 to 1 rad/s
// and 10 m/s^2 at most, what an IMU on a small hexapod sees on hard ground.
constexpr double kStride_hz = 1.0;
constexpr double kBounce_m = 0.011;
constexpr double kSurge_m = 0.005;
constexpr double kSway_m = 0.008;
constexpr double kRoll_rad = 0.03;
constexpr double kPitch_rad = 0.03;
constexpr double kYaw_rad = 0.025;
constexpr double kJolt_m = 0.003;
constexpr double kJolt_rad = 0.01;
constexpr double kJolt_hz = 9.0;
constexpr double kJoltDecay_s = 0.06;
/// Where the feet stand about the body.
constexpr double kFeetAhead_m = 0.28;
constexpr double kFeetAside_m = 0.22;
/// The body follows the slope under its feet by this share.
constexpr double kFollowSlope = 0.75;
/// Feet reach steps up to this; what is higher is not ground.
constexpr double kReach_m = 0.45;
constexpr double kAccelerate_s = 0.8;

/// A path as a dense chain of points, smooth at its corners.
class SmoothPath {
 public:
  explicit SmoothPath(const std::vector<Eigen::Vector2d>& corners) {
    constexpr double kSpacing = 0.01;
    constexpr double kRounding = 0.35;  // m to either side of a corner
    std::vector<Eigen::Vector2d> dense{corners.front()};
    for (std::size_t i = 1; i < corners.size(); ++i) {
      const double length = (corners[i] - corners[i - 1]).norm();
      const int count = std::max(1, static_cast<int>(std::lround(length / kSpacing)));
      for (int k = 1; k <= count; ++k) {
        dense.push_back(corners[i - 1] + (corners[i] - corners[i - 1]) * (static_cast<double>(k) / count));
      }
    }
    // Twice a moving mean: the heading, too, has no corner. The window shrinks towards the ends.
    for (int pass = 0; pass < 2; ++pass) {
      std::vector<Eigen::Vector2d> smooth(dense.size());
      const int reach = static_cast<int>(kRounding / kSpacing);
      const int last = static_cast<int>(dense.size()) - 1;
      for (int i = 0; i <= last; ++i) {
        const int window = std::min({reach, i, last - i});
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (int k = i - window; k <= i + window; ++k) sum += dense[static_cast<std::size_t>(k)];
        smooth[static_cast<std::size_t>(i)] = sum / (2.0 * window + 1.0);
      }
      dense = smooth;
    }
    points_ = dense;
    along_.push_back(0.0);
    for (std::size_t i = 1; i < points_.size(); ++i) {
      along_.push_back(along_.back() + (points_[i] - points_[i - 1]).norm());
    }
  }

  double length() const { return along_.back(); }

  Eigen::Vector2d At(double s) const {
    if (s <= 0.0) return points_.front();
    if (s >= length()) return points_.back();
    const auto after = std::upper_bound(along_.begin(), along_.end(), s);
    const auto i = static_cast<std::size_t>(after - along_.begin());
    const double share = (s - along_[i - 1]) / std::max(along_[i] - along_[i - 1], 1e-12);
    return points_[i - 1] + share * (points_[i] - points_[i - 1]);
  }

  double HeadingAt(double s) const {
    constexpr double kChord = 0.15;
    const Eigen::Vector2d chord =
        At(std::min(s + kChord, length())) - At(std::max(std::min(s, length()) - kChord, 0.0));
    return std::atan2(chord.y(), chord.x());
  }

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> along_;
};

/// Distance along the path: rest, smooth start, constant speed, smooth stop.
struct SpeedProfile {
  double hold_s;
  double speed;
  double length;

  double ramp_s() const { return std::min(kAccelerate_s, length / speed); }
  double done_s() const { return hold_s + length / speed + ramp_s(); }
  /// The smooth rise 3 x^2 - 2 x^3 covers half of what full speed would.
  double SpeedAt(double t) const {
    const double up = std::clamp((t - hold_s) / ramp_s(), 0.0, 1.0);
    const double down = std::clamp((done_s() - t) / ramp_s(), 0.0, 1.0);
    const double x = std::min(up, down);
    return speed * x * x * (3.0 - 2.0 * x);
  }
};

double Unwrap(double angle, double near) {
  return angle - 2.0 * kPi * std::round((angle - near) / (2.0 * kPi));
}

/// A moving mean over time, twice: what legs and springs make of steps in the ground.
void Smooth(std::vector<double>& values, double reach_s) {
  const int reach = static_cast<int>(reach_s / kStep_s);
  const int last = static_cast<int>(values.size()) - 1;
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> sums{0.0};
    for (const double value : values) sums.push_back(sums.back() + value);
    std::vector<double> smooth(values.size());
    for (int i = 0; i <= last; ++i) {
      const int window = std::min({reach, i, last - i});
      smooth[static_cast<std::size_t>(i)] =
          (sums[static_cast<std::size_t>(i + window + 1)] - sums[static_cast<std::size_t>(i - window)]) /
          (2.0 * window + 1.0);
    }
    values = smooth;
  }
}

double DurationOf(const MotionPlan& plan, const SpeedProfile& walk) {
  if (plan.duration_s > 0.0) return plan.duration_s;
  switch (plan.kind) {
    case MotionKind::kWalk:
      return walk.done_s() + plan.hold_end_s;
    case MotionKind::kStand:
    case MotionKind::kCreep:
      return 60.0;
    case MotionKind::kTurnOnSpot:
      return plan.hold_start_s + 2.0 * kPi / plan.turn_radps + kAccelerate_s + plan.hold_end_s;
  }
  return plan.duration_s;
}

bool Walks(const MotionPlan& plan) { return plan.kind == MotionKind::kWalk && plan.path.size() > 1; }

/// When the spline has its control `i`: it reaches one step beyond either end.
double TimeOfControl(int i) { return (i - 1) * kStep_s; }

/// Where the robot is on its way over the ground.
struct WayPoint {
  Eigen::Vector2d at;
  double yaw;
  double activity;  ///< 0 at rest, 1 at full pace

  Eigen::Vector2d ahead() const { return {std::cos(yaw), std::sin(yaw)}; }
  Eigen::Vector2d left() const { return {-std::sin(yaw), std::cos(yaw)}; }
};

std::vector<WayPoint> WayOf(const MotionPlan& plan, const SmoothPath& path, const SpeedProfile& walk,
                            int count) {
  const double heading0 = plan.path.size() > 1 ? path.HeadingAt(0.0) : plan.heading_rad;
  const SpeedProfile turning{plan.hold_start_s, plan.turn_radps, 2.0 * kPi};
  std::vector<WayPoint> way;
  double s = 0.0;
  double turned = 0.0;
  double yaw = heading0;
  for (int i = 0; i < count; ++i) {
    const double t = TimeOfControl(i);
    WayPoint here{plan.path.front(), heading0, 0.0};
    if (Walks(plan)) {
      const double speed = walk.SpeedAt(t);
      s += speed * kStep_s;
      yaw = Unwrap(path.HeadingAt(s), yaw);
      here = {path.At(s), yaw, speed / plan.speed_mps};
    } else if (plan.kind == MotionKind::kCreep) {
      here.at += here.ahead() * plan.creep_mps * std::max(t, 0.0);
    } else if (plan.kind == MotionKind::kTurnOnSpot) {
      const double rate = turning.SpeedAt(t);
      turned += rate * kStep_s;
      here.yaw += turned;
      here.activity = 0.7 * rate / plan.turn_radps;
    }
    way.push_back(here);
  }
  return way;
}

/// Height and slope of the ground under six feet, for each point of a way.
struct Footing {
  std::vector<double> height, slope, tilt;
};

Footing FootingAlong(const std::vector<WayPoint>& way, double start_z, const GroundHeight& ground) {
  Footing footing;
  double level = start_z;
  for (const WayPoint& here : way) {
    const auto height_at = [&](double x, double y) {
      const Eigen::Vector2d foot = here.at + x * here.ahead() + y * here.left();
      const double z = ground({foot.x(), foot.y(), level + kReach_m});
      return std::isnan(z) || z < level - 2.0 * kReach_m ? level : z;
    };
    double front = 0.0, middle = 0.0, rear = 0.0, left_sum = 0.0, right_sum = 0.0;
    for (const double y : {kFeetAside_m, -kFeetAside_m}) {
      const double f = height_at(kFeetAhead_m, y);
      const double m = height_at(0.0, y);
      const double r = height_at(-kFeetAhead_m, y);
      front += 0.5 * f;
      middle += 0.5 * m;
      rear += 0.5 * r;
      (y > 0.0 ? left_sum : right_sum) += (f + m + r) / 3.0;
    }
    level = (front + middle + rear) / 3.0;
    footing.height.push_back(level);
    footing.slope.push_back((front - rear) / (2.0 * kFeetAhead_m));
    footing.tilt.push_back((left_sum - right_sum) / (2.0 * kFeetAside_m));
  }
  Smooth(footing.height, 0.22);
  Smooth(footing.slope, 0.25);
  Smooth(footing.tilt, 0.25);
  return footing;
}

/// What legs make of a body that moves: bounce, roll and pitch with the stride, and a jolt where feet hit.
class Gait {
 public:
  Gait(double bounce, std::uint32_t seed) : bounce_(bounce), random_(Hash(seed, 11)) {}

  /// Goes on to time t. Times ascend by one step of the spline.
  void StepTo(double t, double pace) {
    t_ = t;
    activity_ = bounce_ * pace;
    const double before = phase_;
    // A slower walk takes shorter and fewer steps.
    if (pace > 1e-3) phase_ += kStep_s * kStride_hz * (0.4 + 0.6 * pace);
    if (std::floor(2.0 * phase_) > std::floor(2.0 * before)) Strike();
  }

  double activity() const { return activity_; }
  double stride() const { return 2.0 * kPi * phase_; }
  const std::vector<double>& strikes_s() const { return strikes_s_; }

  struct Swing {
    double lift, roll, pitch;
  };
  Swing SwingNow() const {
    const double step = 2.0 * stride();
    Swing swing;
    swing.lift = activity_ * kBounce_m * (1.0 - std::cos(step)) - activity_ * kBounce_m;
    swing.roll = activity_ * kRoll_rad * std::sin(stride());
    swing.pitch = activity_ * kPitch_rad * std::sin(step + 0.6);
    for (auto jolt = jolts_.rbegin(); jolt != jolts_.rend() && t_ - jolt->t < 8.0 * kJoltDecay_s; ++jolt) {
      const double age = t_ - jolt->t;
      const double echo = std::exp(-age / kJoltDecay_s) * std::sin(2.0 * kPi * kJolt_hz * age);
      swing.lift -= jolt->lift * echo;
      swing.roll += jolt->roll * echo;
      swing.pitch += jolt->pitch * echo;
    }
    return swing;
  }

 private:
  struct Jolt {
    double t, lift, roll, pitch;
  };

  void Strike() {
    strikes_s_.push_back(t_);
    const double sign = std::fmod(std::floor(2.0 * phase_), 2.0) > 0.5 ? 1.0 : -1.0;
    const double force = activity_ * (0.7 + 0.6 * random_.Uniform());
    jolts_.push_back({t_, kJolt_m * force, sign * kJolt_rad * force * (0.4 + 0.6 * random_.Uniform()),
                      kJolt_rad * force * random_.Uniform(-1.0, 1.0)});
  }

  const double bounce_;
  Random random_;
  double t_ = 0.0;
  double activity_ = 0.0;
  double phase_ = 0.0;  ///< of the stride, one for both tripods
  std::vector<Jolt> jolts_;
  std::vector<double> strikes_s_;
};

}  // namespace

Trajectory::Trajectory(std::vector<Vector6d> controls, double step_s, double duration_s,
                       std::vector<double> strikes_s)
    : controls_(std::move(controls)),
      step_s_(step_s),
      duration_s_(duration_s),
      strikes_s_(std::move(strikes_s)) {
  TERRACE_CHECK(controls_.size() >= 4, controls_.size());
}

BodyState Trajectory::At(double t_s) const {
  const double last = static_cast<double>(controls_.size()) - 3.0;
  const double x = std::clamp(t_s / step_s_, 0.0, last - 1e-9);
  const auto i = static_cast<std::size_t>(x);
  const double f = x - static_cast<double>(i);
  const Vector6d& p0 = controls_[i];
  const Vector6d& p1 = controls_[i + 1];
  const Vector6d& p2 = controls_[i + 2];
  const Vector6d& p3 = controls_[i + 3];
  const double g = 1.0 - f;
  const Vector6d value = (g * g * g * p0 + (3 * f * f * f - 6 * f * f + 4) * p1 +
                          (-3 * f * f * f + 3 * f * f + 3 * f + 1) * p2 + f * f * f * p3) /
                         6.0;
  const Vector6d rate =
      (-g * g * p0 + (3 * f * f - 4 * f) * p1 + (-3 * f * f + 2 * f + 1) * p2 + f * f * p3) / (2.0 * step_s_);
  const Vector6d second = (g * p0 + (3 * f - 2) * p1 + (-3 * f + 1) * p2 + f * p3) / (step_s_ * step_s_);
  BodyState state;
  const double roll = value[3];
  const double pitch = value[4];
  state.T_world_body.translation() = value.head<3>();
  state.T_world_body.linear() =
      (Eigen::AngleAxisd(value[5], Eigen::Vector3d::UnitZ()) *
       Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  state.v_world = rate.head<3>();
  state.a_world = second.head<3>();
  // Turn rate in body axes from the rates of the angles of Rz(yaw) Ry(pitch) Rx(roll).
  state.omega_body = {rate[3] - rate[5] * std::sin(pitch),
                      rate[4] * std::cos(roll) + rate[5] * std::sin(roll) * std::cos(pitch),
                      -rate[4] * std::sin(roll) + rate[5] * std::cos(roll) * std::cos(pitch)};
  return state;
}

Trajectory PlanMotion(const MotionPlan& plan, const Mounting& mounting, const GroundHeight& ground,
                      std::uint32_t seed) {
  TERRACE_CHECK(!plan.path.empty());
  const SmoothPath path(plan.path.size() > 1 ? plan.path
                                             : std::vector<Eigen::Vector2d>(2, plan.path.front()));
  const SpeedProfile walk{plan.hold_start_s, plan.speed_mps, std::max(path.length(), 1e-6)};
  const double duration = DurationOf(plan, walk);
  const std::vector<WayPoint> way =
      WayOf(plan, path, walk, static_cast<int>(std::ceil(duration / kStep_s)) + 4);
  const Footing footing = FootingAlong(way, plan.start_z, ground);
  Gait gait(plan.bounce, seed);
  std::vector<Vector6d> controls;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const WayPoint& here = way[i];
    const double t = TimeOfControl(static_cast<int>(i));
    gait.StepTo(t, here.activity);
    const Gait::Swing swing = gait.SwingNow();
    // At rest a robot on servos is never quite still: tenths of a millimetre.
    constexpr double kTremble_m = 1e-4;
    constexpr double kTremble_rad = 1e-4;
    const double gaze = plan.gaze_rad * here.activity * (Walks(plan) ? 1.0 : 0.0);
    const Eigen::Vector2d at =
        here.at + gait.activity() * kSurge_m * std::sin(2.0 * gait.stride()) * here.ahead() +
        (gait.activity() * kSway_m * std::sin(gait.stride() + 0.5) + kTremble_m * std::sin(2.1 * t)) *
            here.left();
    Vector6d control;
    control << at.x(), at.y(),
        footing.height[i] + mounting.body_height_m + swing.lift + kTremble_m * std::sin(3.7 * t),
        swing.roll + kFollowSlope * std::atan(footing.tilt[i]) + kTremble_rad * std::sin(2.9 * t),
        swing.pitch - kFollowSlope * std::atan(footing.slope[i]) + kTremble_rad * std::sin(1.7 * t),
        here.yaw + gait.activity() * kYaw_rad * std::sin(gait.stride()) +
            gaze * std::sin(2.0 * kPi * 0.21 * t);
    controls.push_back(control);
  }
  return Trajectory(std::move(controls), kStep_s, duration, gait.strikes_s());
}

}  // namespace terrace::synthetic
