// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "datasets/image_file.h"

namespace terrace {

/// Writes an EuRoC ASL folder of a few small pairs with everything in it that a log must carry: a raw
/// calibration with awkward digits, a mounting, IMU with noise, attitude, legs, true poses, and nanoseconds
/// that are no whole microseconds. Frame `bad_frame` cannot be read; -1: all can.
inline void WriteTinyEuroc(const std::filesystem::path& folder, int num_frames, int bad_frame) {
  namespace fs = std::filesystem;
  constexpr int kWidth = 96, kHeight = 64;
  constexpr std::int64_t kFirst = 1600000000000000123, kFramePeriod = 66666667, kImuPeriod = 5000003;
  const fs::path mav = folder / "mav0";
  const auto open = [&](const std::string& file) {
    fs::create_directories((mav / file).parent_path());
    std::ofstream out(mav / file);
    out.precision(17);
    return out;
  };
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  const auto numbers = [&](std::ostream& out, int count) {
    for (int i = 0; i < count; ++i) out << ',' << noise(random);
    return "\n";
  };

  for (const int camera : {0, 1}) {
    const std::string name = "cam" + std::to_string(camera);
    open(name + "/sensor.yaml")
        << "T_BS:\n  rows: 4\n  cols: 4\n  data: [0.0148655429818, -0.999880929698, 0.00414029679422, "
        << (camera == 0 ? "-0.0216401454975" : "-0.0198435579556")
        << ", 0.999557249008, 0.0149672133247, 0.025715529948, "
        << (camera == 0 ? "-0.064676986768" : "0.0453689425024")
        << ", -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949, 0, 0, 0, 1]\n"
        << "resolution: [" << kWidth << ", " << kHeight << "]\ncamera_model: pinhole\n"
        << "intrinsics: [58.6541, 57.2962, " << 47.2151 + camera << ", 31.3757]\n"
        << "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28340811, 0.07395907, "
           "0.00019359, "
        << 1.76187114e-05 * (camera + 1) << "]\n";
    std::ofstream csv = open(name + "/data.csv");
    csv << "#timestamp [ns],filename\n";
    fs::create_directories(mav / name / "data");
    for (int i = 0; i < num_frames; ++i) {
      const std::int64_t t = kFirst + i * kFramePeriod;
      csv << t << ',' << t << ".png\n";
      GrayImage image{kWidth, kHeight, {}};
      for (int p = 0; p < kWidth * kHeight; ++p) image.data.push_back(static_cast<std::uint8_t>(random()));
      const fs::path png = mav / name / "data" / (std::to_string(t) + ".png");
      WritePng(png, image);
      if (i == bad_frame && camera == 1) std::ofstream(png) << "no image";
    }
  }
  open("imu0/sensor.yaml")
      << "T_BS:\n  data: [0.36, 0.48, -0.8, 0.1, -0.8, 0.6, 0, 0.2, 0.48, 0.64, 0.6, 0.3, 0, 0, 0, 1]\n"
      << "gyroscope_noise_density: 1.6968e-04\ngyroscope_random_walk: 1.9393e-05\n"
      << "accelerometer_noise_density: 2.0000e-3\naccelerometer_random_walk: 3.0000e-3\n";
  std::ofstream imu = open("imu0/data.csv");
  std::ofstream attitude = open("attitude0/data.csv");
  std::ofstream legs = open("legs0/data.csv");
  std::ofstream truth = open("state_groundtruth_estimate0/data.csv");
  // From before the first frame to behind the last.
  for (std::int64_t t = kFirst - 10 * kImuPeriod; t < kFirst + num_frames * kFramePeriod; t += kImuPeriod) {
    imu << t;
    imu << numbers(imu, 6);
    const double angle = 1e-10 * static_cast<double>(t - kFirst);
    const auto pose = [&](std::ostream& out) {
      out << t << ',' << angle << ",0.5,0.25," << std::cos(angle) << ',' << 0.6 * std::sin(angle) << ",0,"
          << 0.8 * std::sin(angle);
    };
    pose(attitude);
    attitude << ",0.01,0.01,0.5,0,0,0\n";
    pose(legs);
    legs << ",0.01,0.01,0.02,0.003,0.003,0.003\n";
    pose(truth);
    truth << ",0,0,0,0,0,0,0,0,0\n";
  }
}

}  // namespace terrace
