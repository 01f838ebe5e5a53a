// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "datasets/image_file.h"
#include "temporary_folder.h"

namespace terrace {

inline constexpr int kSmallWidth = 32;
inline constexpr int kSmallHeight = 24;
inline constexpr int kSmallFrames = 4;

/// Frame i of a small sequence was taken at this time [ns].
inline std::int64_t SmallTime(int i) { return 1'000'000'000 + 100'000'000LL * i; }

/// A picture that is different for every seed.
inline GrayImage SmallImage(int seed, int width = kSmallWidth, int height = kSmallHeight) {
  GrayImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.data.push_back(static_cast<std::uint8_t>(i * 7 + seed * 31));
  return image;
}

inline std::string SmallSensorYaml(double y_of_camera) {
  return "sensor_type: camera\n"
         "T_BS:\n  cols: 4\n  rows: 4\n"
         "  data: [0, 0, 1, 0.2,\n         -1, 0, 0, " +
         std::to_string(y_of_camera) +
         ",\n         0, -1, 0, 0.1,\n         0, 0, 0, 1]\n"
         "rate_hz: 10\nresolution: [32, 24]\ncamera_model: pinhole\n"
         "intrinsics: [30.0, 30.0, 15.5, 11.5]\ndistortion_model: radial-tangential\n"
         "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n";
}

/// A valid EuRoC ASL folder with 4 frames, IMU at 50 Hz, both priors and true body poses.
inline void WriteSmallEuroc(const std::filesystem::path& path) {
  const std::filesystem::path mav = path / "mav0";
  for (int side = 0; side < 2; ++side) {
    const std::filesystem::path camera = mav / ("cam" + std::to_string(side));
    WriteText(camera / "sensor.yaml", SmallSensorYaml(side == 0 ? 0.05 : -0.05));
    std::string csv = "#timestamp [ns],filename\n";
    std::filesystem::create_directories(camera / "data");
    for (int i = 0; i < kSmallFrames; ++i) {
      const std::string name = std::to_string(SmallTime(i)) + ".png";
      csv += std::to_string(SmallTime(i)) + "," + name + "\r\n";
      WritePng(camera / "data" / name, SmallImage(2 * i + side));
    }
    WriteText(camera / "data.csv", csv);
  }
  std::string imu = "#timestamp [ns],w_RS_S_x [rad s^-1],...\n";
  std::string attitude = "timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z, sigmas\n";
  std::string legs = attitude;
  std::string truth = "#timestamp, p_RS_R_x [m], ...\n";
  for (int i = 0; i <= 20; ++i) {
    const std::string t = std::to_string(SmallTime(0) - 50'000'000 + 20'000'000LL * i);
    imu += t + ",0.1,0.2," + std::to_string(0.01 * i) + ",0,0,9.81\n";
    attitude += t + ",0,0,0,1,0,0,0,0.01,0.02,3,0,0,0\n";
    legs += t + "," + std::to_string(0.02 * i) +
            ",0,0.4,0.70710678,0,0,0.70710678,0.01,0.01,0.01,0.002,0.002,0.003\n";
    truth += t + "," + std::to_string(0.02 * i) + ",0,0.4,0.70710678,0,0,0.70710678,0,0,0,0,0,0,0,0,0\n";
  }
  WriteText(mav / "imu0" / "data.csv", imu);
  WriteText(mav / "imu0" / "sensor.yaml",
            "sensor_type: imu\nT_BS:\n  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nrate_hz: 50\n"
            "gyroscope_noise_density: 1.7e-4\n");
  WriteText(mav / "attitude0" / "data.csv", attitude);
  WriteText(mav / "legs0" / "data.csv", legs);
  WriteText(mav / "state_groundtruth_estimate0" / "data.csv", truth);
}

/// A valid KITTI odometry folder with 4 frames and true poses.
/// @param first_camera  0: grey, 2: colour.
inline void WriteSmallKitti(const std::filesystem::path& path, int first_camera = 0) {
  for (int side = 0; side < 2; ++side) {
    const std::filesystem::path folder = path / ("image_" + std::to_string(first_camera + side));
    std::filesystem::create_directories(folder);
    for (int i = 0; i < kSmallFrames; ++i) {
      char name[16];
      std::snprintf(name, sizeof(name), "%06d.png", i);
      WritePng(folder / name, SmallImage(2 * i + side));
    }
  }
  // Camera 2 is 6 cm left of camera 0, camera 3 is 47 cm right of it.
  WriteText(path / "calib.txt",
            "P0: 30 0 15.5 0 0 30 11.5 0 0 0 1 0\nP1: 30 0 15.5 -16.2 0 30 11.5 0 0 0 1 0\n"
            "P2: 30 0 15.5 1.8 0 30 11.5 0 0 0 1 0.0038\nP3: 30 0 15.5 -14.1 0 30 11.5 0.08 0 0 1 0.0049\n"
            "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  std::string times, poses;
  for (int i = 0; i < kSmallFrames; ++i) {
    times += std::to_string(i) + ".037359e-01\n";
    poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(0.8 * i) + "\n";
  }
  WriteText(path / "times.txt", times);
  WriteText(path / "poses.txt", poses);
}

}  // namespace terrace
