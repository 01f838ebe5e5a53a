// SPDX-License-Identifier: BSD-3-Clause
// tiny_log OUT.lcmlog NUM_FRAMES: writes the tiny sequence as an LCM log, with an IMU that is at rest.

#include <cstdlib>

#include "datasets/lcm_log_writer.h"
#include "test/daemon/tiny_world.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  terrace::StereoCalibration calibration = terrace::test::TinyCalibration();
  calibration.T_body_imu = Eigen::Isometry3d::Identity();
  terrace::LcmLogWriter writer(argv[1], calibration, {}, terrace::ImageEncoding::kRaw);
  std::int64_t t_imu_ns = 1'600'000'000'000'000'000 - 500'000'000;
  for (terrace::SensorFrame& frame : terrace::test::TinySequence(std::atoi(argv[2]))) {
    for (; t_imu_ns <= frame.pair.t_capture.ns; t_imu_ns += 10'000'003) {
      frame.samples.imu.push_back({{t_imu_ns}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    }
    writer.Add(frame);
  }
  writer.Finish();
}
