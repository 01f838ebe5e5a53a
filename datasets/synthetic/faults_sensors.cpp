// SPDX-License-Identifier: BSD-3-Clause
// Faults of IMU, body attitude and leg odometry.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "datasets/synthetic/fault.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

using Edit = std::function<void(ImuSample& sample, double strength)>;
using Apply = std::function<void(FaultyRecording&, const FaultSpan&, double)>;

constexpr double kOneG = 9.81;

std::chrono::nanoseconds Milliseconds(double ms) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(1e6 * ms)));
}

void MustHave(bool has, const FaultyRecording& recording, const char* sensor) {
  if (!has) throw FaultError(recording.source.string() + ": has no " + sensor);
}

/// Every sample from the first to the last.
Apply Always(Edit edit) {
  return [edit = std::move(edit)](FaultyRecording& recording, const FaultSpan&, double strength) {
    MustHave(!recording.imu.empty(), recording, "IMU");
    for (ImuSample& sample : recording.imu) edit(sample, strength);
  };
}

/// From the beginning of the fault on.
Apply FromThen(Edit edit) {
  return [edit = std::move(edit)](FaultyRecording& recording, const FaultSpan& span, double strength) {
    MustHave(!recording.imu.empty(), recording, "IMU");
    for (ImuSample& sample : recording.imu)
      if (sample.t >= span.t_begin) edit(sample, strength);
  };
}

void FreezeImu(FaultyRecording& recording, const FaultSpan& span, double) {
  MustHave(!recording.imu.empty(), recording, "IMU");
  ImuSample last = recording.imu.front();
  for (ImuSample& sample : recording.imu) {
    if (sample.t >= span.t_begin) sample.gyro = last.gyro, sample.accel = last.accel;
    last = sample;
  }
}

using EditPose = std::function<void(RecordedPrior& prior, double strength)>;

/// Of legs or attitude, for the given times.
template <typename When>
Apply Priors(std::vector<RecordedPrior> FaultyRecording::*which, const char* name, When when, EditPose edit) {
  return [=](FaultyRecording& recording, const FaultSpan& span, double strength) {
    MustHave(!(recording.*which).empty(), recording, name);
    for (RecordedPrior& prior : recording.*which)
      if (when(prior.t, span)) edit(prior, strength);
  };
}

bool Ever(Timestamp, const FaultSpan&) { return true; }
bool Later(Timestamp t, const FaultSpan& span) { return t >= span.t_begin; }

template <typename When>
Apply Legs(When when, EditPose edit) {
  return Priors(&FaultyRecording::legs, "leg odometry", when, std::move(edit));
}
template <typename When>
Apply Attitude(When when, EditPose edit) {
  return Priors(&FaultyRecording::attitude, "body attitude", when, std::move(edit));
}

void Tilt(RecordedPrior& prior, double angle_deg) {
  Eigen::Isometry3d T = prior.T_odom_body();
  T.linear() = Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitX()) * T.linear();
  prior.Set(T);
}

void ScalePosition(RecordedPrior& prior, double factor) {
  for (std::size_t i = 0; i < 3; ++i) prior.values[i] *= factor;
}

void Freeze(std::vector<RecordedPrior>& priors, const FaultSpan& span) {
  for (std::size_t i = 1; i < priors.size(); ++i)
    if (priors[i].t >= span.t_begin) priors[i].Set(priors[i - 1].T_odom_body());
}

}  // namespace

std::vector<Fault> ImuFaults() {
  return {
      {"imu_in_g", "the accelerometer measures in g", 1,
       Always([](ImuSample& s, double) { s.accel /= kOneG; })},
      {"imu_turned", "the accelerometer's sign is turned", 1,
       Always([](ImuSample& s, double) { s.accel *= -1; })},
      {"imu_silent", "accelerometer and gyroscope say zero", 1,
       Always([](ImuSample& s, double) { s.accel.setZero(), s.gyro.setZero(); })},
      {"imu_in_degrees", "the gyroscope measures in degrees per second", 1,
       Always([](ImuSample& s, double) { s.gyro *= 180.0 / std::numbers::pi; })},
      {"imu_gyro_turned", "the gyroscope's sign is turned", 1,
       Always([](ImuSample& s, double) { s.gyro *= -1; })},
      {"imu_axes", "x and y of the IMU are exchanged", 1, Always([](ImuSample& s, double) {
         std::swap(s.gyro.x(), s.gyro.y()), std::swap(s.accel.x(), s.accel.y());
       })},
      {"imu_other_clock", "the IMU's clock runs since the start of the machine", 1,
       Always([](ImuSample& s, double) { s.t.ns %= 1'000'000'000'000; })},
      {"imu_in_ms", "the IMU's time stamps are in milliseconds", 1,
       Always([](ImuSample& s, double) { s.t.ns /= 1'000'000; })},
      {"imu_late", "the IMU's time stamps are late by so many milliseconds", 50,
       Always([](ImuSample& s, double ms) { s.t = s.t + Milliseconds(ms); })},
      {"imu_early", "the IMU's time stamps are early by so many milliseconds", 50,
       Always([](ImuSample& s, double ms) { s.t = s.t - Milliseconds(ms); })},
      {"imu_accel_bias", "the accelerometer's bias jumps by so many m/s^2", 1,
       FromThen([](ImuSample& s, double a) { s.accel.x() += a; })},
      {"imu_gyro_bias", "the gyroscope's bias jumps by so many rad/s", 0.3,
       FromThen([](ImuSample& s, double w) { s.gyro.z() += w; })},
      {"imu_tilted", "the IMU is mounted so many degrees otherwise than the calibration says", 5,
       Always([](ImuSample& s, double angle_deg) {
         const Eigen::AngleAxisd turn(angle_deg * std::numbers::pi / 180.0,
                                      Eigen::Vector3d(1.0, 1.0, 1.0).normalized());
         s.gyro = turn * s.gyro, s.accel = turn * s.accel;
       })},
      {"imu_gyro_scaled", "the gyroscope shows so many times the turn", 1.2,
       Always([](ImuSample& s, double factor) { s.gyro *= factor; })},
      {"imu_accel_scaled", "the accelerometer shows so many times what it should", 1.1,
       Always([](ImuSample& s, double factor) { s.accel *= factor; })},
      {"imu_clock_drifts", "the IMU's clock gains so many milliseconds a second", 20,
       [](FaultyRecording& r, const FaultSpan&, double ms) {
         MustHave(!r.imu.empty(), r, "IMU");
         const Timestamp first = r.imu.front().t;
         for (ImuSample& s : r.imu) s.t = s.t + Milliseconds(ms * Seconds(s.t - first));
       }},
      {"imu_clock_jumps", "the IMU's clock is set forward by so many milliseconds", 100,
       [](FaultyRecording& r, const FaultSpan& span, double ms) {
         MustHave(!r.imu.empty(), r, "IMU");
         for (ImuSample& s : r.imu)
           if (s.t >= span.t_begin) s.t = s.t + Milliseconds(ms);
       }},
      {"imu_sparse", "this share of the IMU's samples does not arrive", 0.5,
       [](FaultyRecording& r, const FaultSpan&, double share) {
         MustHave(!r.imu.empty(), r, "IMU");
         Random random(13);
         std::erase_if(r.imu, [&](const ImuSample&) { return random.Uniform(0.0, 1.0) < share; });
       }},
      {"imu_noisy", "the accelerometer jitters by so many m/s^2, the gyroscope by a tenth of it in rad/s", 2,
       [](FaultyRecording& r, const FaultSpan&, double sigma) {
         MustHave(!r.imu.empty(), r, "IMU");
         Random random(17);
         for (ImuSample& s : r.imu)
           for (int i = 0; i < 3; ++i)
             s.accel[i] += sigma * random.Gaussian(), s.gyro[i] += 0.1 * sigma * random.Gaussian();
       }},
      {"imu_clipped", "the accelerometer cannot show more than so many m/s^2", 9,
       Always([](ImuSample& s, double a) { s.accel = s.accel.cwiseMax(-a).cwiseMin(a); })},
      {"imu_frozen", "the IMU says the same again and again", 1, FreezeImu},
      {"imu_stops", "the IMU says nothing any more", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         std::erase_if(r.imu, [&](const ImuSample& s) { return s.t >= span.t_begin; });
       }},
      {"imu_gap", "the IMU says nothing for a while", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         std::erase_if(r.imu, [&](const ImuSample& s) { return span.Holds(s.t); });
       }},
      {"imu_spike", "one reading of the accelerometer is so many m/s^2", 1e6,
       [](FaultyRecording& r, const FaultSpan& span, double a) {
         for (ImuSample& s : r.imu)
           if (s.t >= span.t_begin) {
             s.accel.x() = a;
             return;
           }
       }},
  };
}

std::vector<Fault> PriorFaults() {
  return {
      {"legs_jump", "leg odometry jumps by so many metres", 5,
       Legs(Later, [](RecordedPrior& p, double m) { p.values[0] += m; })},
      {"legs_in_mm", "leg odometry is in millimetres", 1000,
       Legs(Ever, [](RecordedPrior& p, double factor) { ScalePosition(p, factor); })},
      {"legs_late", "the time stamps of leg odometry are so many milliseconds late", 200,
       [](FaultyRecording& r, const FaultSpan&, double ms) {
         MustHave(!r.legs.empty(), r, "leg odometry");
         for (RecordedPrior& p : r.legs) p.t = p.t + Milliseconds(ms);
       }},
      {"legs_in_cm", "leg odometry is in centimetres", 100,
       Legs(Ever, [](RecordedPrior& p, double factor) { ScalePosition(p, factor); })},
      {"legs_backwards", "leg odometry goes backwards where the body goes ahead", 1,
       Legs(Ever, [](RecordedPrior& p, double) { p.values[0] *= -1, p.values[1] *= -1; })},
      {"attitude_late", "the time stamps of the body attitude are so many milliseconds late", 200,
       [](FaultyRecording& r, const FaultSpan&, double ms) {
         MustHave(!r.attitude.empty(), r, "body attitude");
         for (RecordedPrior& p : r.attitude) p.t = p.t + Milliseconds(ms);
       }},
      {"attitude_drifts", "roll of the body attitude drifts by so many degrees a second", 1,
       [](FaultyRecording& r, const FaultSpan&, double deg_s) {
         MustHave(!r.attitude.empty(), r, "body attitude");
         const Timestamp first = r.attitude.front().t;
         for (RecordedPrior& p : r.attitude) Tilt(p, deg_s * Seconds(p.t - first));
       }},
      {"legs_scaled", "leg odometry goes so many times too far", 2,
       Legs(Ever, [](RecordedPrior& p, double factor) { ScalePosition(p, factor); })},
      {"legs_frozen", "leg odometry stands still", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         MustHave(!r.legs.empty(), r, "leg odometry");
         Freeze(r.legs, span);
       }},
      {"legs_slip", "the feet slip: leg odometry goes on at so many m/s more", 0.5,
       [](FaultyRecording& r, const FaultSpan& span, double mps) {
         MustHave(!r.legs.empty(), r, "leg odometry");
         for (RecordedPrior& p : r.legs)
           if (p.t >= span.t_begin) p.values[0] += mps * Seconds(std::min(p.t, span.t_end) - span.t_begin);
       }},
      {"legs_noisy", "leg odometry jitters by so many metres", 0.2,
       [](FaultyRecording& r, const FaultSpan&, double sigma_m) {
         MustHave(!r.legs.empty(), r, "leg odometry");
         Random random(7);
         for (RecordedPrior& p : r.legs)
           for (std::size_t i = 0; i < 3; ++i) p.values[i] += sigma_m * random.Gaussian();
       }},
      {"legs_turned", "leg odometry takes left for right", 1,
       Legs(Ever, [](RecordedPrior& p, double) { p.values[1] *= -1, p.values[6] *= -1, p.values[4] *= -1; })},
      {"legs_tilted", "roll of the leg odometry is so many degrees off", 20,
       Legs(Later, [](RecordedPrior& p, double angle_deg) { Tilt(p, angle_deg); })},
      {"attitude_jump", "the body attitude jumps by so many degrees", 20,
       Attitude(Later, [](RecordedPrior& p, double angle_deg) { Tilt(p, angle_deg); })},
      {"attitude_off", "the body attitude is so many degrees off from the start", 20,
       Attitude(Ever, [](RecordedPrior& p, double angle_deg) { Tilt(p, angle_deg); })},
      {"attitude_inverted", "the body attitude is the inverse rotation", 1,
       Attitude(Ever,
                [](RecordedPrior& p, double) {
                  for (std::size_t i = 4; i < 7; ++i) p.values[i] *= -1;
                })},
      {"attitude_xyzw", "the quaternion of the body attitude is x y z w", 1,
       Attitude(Ever,
                [](RecordedPrior& p, double) {
                  const auto v = p.values;
                  p.values[3] = v[4], p.values[4] = v[5], p.values[5] = v[6], p.values[6] = v[3];
                })},
      {"attitude_frozen", "the body attitude stands still", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         MustHave(!r.attitude.empty(), r, "body attitude");
         Freeze(r.attitude, span);
       }},
  };
}

}  // namespace terrace::synthetic
