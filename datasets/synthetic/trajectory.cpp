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
  const bool walks = plan.kind == MotionKind::kWalk && plan.path.size() > 1;
  const SmoothPath path(plan.path.size() > 1 ? plan.path
                                             : std::vector<Eigen::Vector2d>(2, plan.path.front()));
  const SpeedProfile profile{plan.hold_start_s, plan.speed_mps, std::max(path.length(), 1e-6)};
  const double heading0 = plan.path.size() > 1 ? path.HeadingAt(0.0) : plan.heading_rad;
  double duration = plan.duration_s;
  if (duration <= 0.0) {
    switch (plan.kind) {
      case MotionKind::kWalk:
        duration = profile.done_s() + plan.hold_end_s;
        break;
      case MotionKind::kStand:
      case MotionKind::kCreep:
        duration = 60.0;
        break;
      case MotionKind::kTurnOnSpot:
        duration = plan.hold_start_s + 2.0 * kPi / plan.turn_radps + kAccelerate_s + plan.hold_end_s;
        break;
    }
  }
  // The spline reaches one step beyond either end.
  const int count = static_cast<int>(std::ceil(duration / kStep_s)) + 4;
  const auto time_of = [](int i) { return (i - 1) * kStep_s; };

  // Way over the ground.
  struct Ground {
    Eigen::Vector2d at;
    double yaw;
    double activity;  // 0 at rest, 1 at full pace
  };
  std::vector<Ground> way;
  const SpeedProfile turning{plan.hold_start_s, plan.turn_radps, 2.0 * kPi};
  double s = 0.0;
  double turned = 0.0;
  double yaw = heading0;
  for (int i = 0; i < count; ++i) {
    const double t = time_of(i);
    Ground here{plan.path.front(), heading0, 0.0};
    const Eigen::Vector2d ahead(std::cos(heading0), std::sin(heading0));
    if (walks) {
      const double speed = profile.SpeedAt(t);
      s += speed * kStep_s;
      yaw = Unwrap(path.HeadingAt(s), yaw);
      here = {path.At(s), yaw, speed / plan.speed_mps};
    } else if (plan.kind == MotionKind::kCreep) {
      here.at += ahead * plan.creep_mps * std::max(t, 0.0);
    } else if (plan.kind == MotionKind::kTurnOnSpot) {
      const double rate = turning.SpeedAt(t);
      turned += rate * kStep_s;
      here.yaw += turned;
      here.activity = 0.7 * rate / plan.turn_radps;
    }
    way.push_back(here);
  }

  // Height and slope of the ground under six feet.
  std::vector<double> height, slope, tilt;
  double level = plan.start_z;
  for (const Ground& here : way) {
    const Eigen::Vector2d ahead(std::cos(here.yaw), std::sin(here.yaw));
    const Eigen::Vector2d left(-ahead.y(), ahead.x());
    const auto side = [&](double x, double y) {
      const Eigen::Vector2d foot = here.at + x * ahead + y * left;
      const double z = ground({foot.x(), foot.y(), level + kReach_m});
      return std::isnan(z) || z < level - 2.0 * kReach_m ? level : z;
    };
    double front = 0.0, middle = 0.0, rear = 0.0, left_sum = 0.0, right_sum = 0.0;
    for (const double y : {kFeetAside_m, -kFeetAside_m}) {
      const double f = side(kFeetAhead_m, y);
      const double m = side(0.0, y);
      const double r = side(-kFeetAhead_m, y);
      front += 0.5 * f;
      middle += 0.5 * m;
      rear += 0.5 * r;
      (y > 0.0 ? left_sum : right_sum) += (f + m + r) / 3.0;
    }
    level = (front + middle + rear) / 3.0;
    height.push_back(level);
    slope.push_back((front - rear) / (2.0 * kFeetAhead_m));
    tilt.push_back((left_sum - right_sum) / (2.0 * kFeetAside_m));
  }
  Smooth(height, 0.22);
  Smooth(slope, 0.25);
  Smooth(tilt, 0.25);

  // Gait.
  Random random(Hash(seed, 11));
  std::vector<double> strikes;
  struct Jolt {
    double t, lift, roll, pitch;
  };
  std::vector<Jolt> jolts;
  std::vector<Vector6d> controls;
  double phase = 0.0;  // of the stride, one for both tripods
  for (int i = 0; i < count; ++i) {
    const double t = time_of(i);
    const Ground& here = way[static_cast<std::size_t>(i)];
    const double activity = plan.bounce * here.activity;
    const double before = phase;
    // A slower walk takes shorter and fewer steps.
    if (here.activity > 1e-3) phase += kStep_s * kStride_hz * (0.4 + 0.6 * here.activity);
    if (std::floor(2.0 * phase) > std::floor(2.0 * before)) {
      strikes.push_back(t);
      const double sign = std::fmod(std::floor(2.0 * phase), 2.0) > 0.5 ? 1.0 : -1.0;
      const double force = activity * (0.7 + 0.6 * random.Uniform());
      jolts.push_back({t, kJolt_m * force, sign * kJolt_rad * force * (0.4 + 0.6 * random.Uniform()),
                       kJolt_rad * force * random.Uniform(-1.0, 1.0)});
    }
    const double stride = 2.0 * kPi * phase;
    const double step = 2.0 * stride;
    double lift = activity * kBounce_m * (1.0 - std::cos(step)) - activity * kBounce_m;
    double roll = activity * kRoll_rad * std::sin(stride);
    double pitch = activity * kPitch_rad * std::sin(step + 0.6);
    for (auto jolt = jolts.rbegin(); jolt != jolts.rend() && t - jolt->t < 8.0 * kJoltDecay_s; ++jolt) {
      const double age = t - jolt->t;
      const double swing = std::exp(-age / kJoltDecay_s) * std::sin(2.0 * kPi * kJolt_hz * age);
      lift -= jolt->lift * swing;
      roll += jolt->roll * swing;
      pitch += jolt->pitch * swing;
    }
    // At rest a robot on servos is never quite still: tenths of a millimetre.
    constexpr double kTremble_m = 1e-4;
    constexpr double kTremble_rad = 1e-4;
    const double gaze = plan.gaze_rad * here.activity * (walks ? 1.0 : 0.0);
    const Eigen::Vector2d ahead(std::cos(here.yaw), std::sin(here.yaw));
    const Eigen::Vector2d left(-ahead.y(), ahead.x());
    const Eigen::Vector2d at =
        here.at + activity * kSurge_m * std::sin(step) * ahead +
        (activity * kSway_m * std::sin(stride + 0.5) + kTremble_m * std::sin(2.1 * t)) * left;
    Vector6d control;
    control << at.x(), at.y(),
        height[static_cast<std::size_t>(i)] + mounting.body_height_m + lift + kTremble_m * std::sin(3.7 * t),
        roll + kFollowSlope * std::atan(tilt[static_cast<std::size_t>(i)]) + kTremble_rad * std::sin(2.9 * t),
        pitch - kFollowSlope * std::atan(slope[static_cast<std::size_t>(i)]) +
            kTremble_rad * std::sin(1.7 * t),
        here.yaw + activity * kYaw_rad * std::sin(stride) + gaze * std::sin(2.0 * kPi * 0.21 * t);
    controls.push_back(control);
  }
  return Trajectory(std::move(controls), kStep_s, duration, std::move(strikes));
}

}  // namespace terrace::synthetic
