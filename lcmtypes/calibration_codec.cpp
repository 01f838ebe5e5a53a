// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/calibration_codec.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <span>

#include "core/check.h"
#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

/// Names of the lens models in messages, by DistortionModel.
constexpr std::array kModelNames = {"pinhole-radtan",   "pinhole-equidistant", "omni",      "double-sphere",
                                    "extended-unified", "field-of-view",       "polynomial"};

/// A number that changes when the bytes do (FNV-1a), in hexadecimal.
std::string ContentHash(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

void WriteCamera(const RawCamera& camera, std::size_t num_distortion, double* K,
                 std::vector<double>* distortion) {
  const double matrix[9] = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  std::copy(std::begin(matrix), std::end(matrix), K);
  *distortion = camera.distortion;
  distortion->resize(num_distortion, 0.0);
}

RawCamera ReadCamera(const double* K, DistortionModel model, const std::vector<double>& distortion) {
  return {K[0], K[4], K[2], K[5], model, distortion};
}

}  // namespace

calibration_v1_t ToMessage(const StereoCalibration& calibration, Timestamp t) {
  TERRACE_CHECK(calibration.left.model == calibration.right.model);
  calibration_v1_t message{};
  message.width = calibration.width;
  message.height = calibration.height;
  message.rectified = calibration.rectified();
  const std::size_t num_distortion =
      std::max(calibration.left.distortion.size(), calibration.right.distortion.size());
  message.n_dist = static_cast<std::int32_t>(num_distortion);
  message.dist.resize(2);
  WriteCamera(calibration.left, num_distortion, message.K[0], &message.dist[0]);
  WriteCamera(calibration.right, num_distortion, message.K[1], &message.dist[1]);
  message.model = kModelNames.at(static_cast<std::size_t>(calibration.left.model));
  for (int i = 0; i < 9; ++i) message.R_right_left[i] = calibration.T_rawright_rawleft.linear()(i / 3, i % 3);
  WriteVector(calibration.T_rawright_rawleft.translation(), message.t_right_left);
  if (calibration.T_body_rawleft) {
    WritePose(*calibration.T_body_rawleft, message.body_from_left_pos, message.body_from_left_quat);
  }
  if (calibration.T_body_imu) {
    WritePose(*calibration.T_body_imu, message.body_from_imu_pos, message.body_from_imu_quat);
  }
  message.imu_noise[0] = calibration.imu_noise.gyro_density;
  message.imu_noise[1] = calibration.imu_noise.gyro_walk;
  message.imu_noise[2] = calibration.imu_noise.accel_density;
  message.imu_noise[3] = calibration.imu_noise.accel_walk;

  std::vector<std::uint8_t> content(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(content.data(), 0, static_cast<int>(content.size()));
  message.content_hash = ContentHash(content);
  message.utime = t.utime();
  message.name = calibration.name;
  return message;
}

std::optional<StereoCalibration> FromMessage(const calibration_v1_t& message) {
  StereoCalibration calibration;
  const auto name = std::find(kModelNames.begin(), kModelNames.end(), message.model);
  if (name == kModelNames.end()) return std::nullopt;
  const auto model = static_cast<DistortionModel>(name - kModelNames.begin());
  calibration.name = PlainText(message.name);
  calibration.width = message.width;
  calibration.height = message.height;
  calibration.left = ReadCamera(message.K[0], model, message.dist[0]);
  calibration.right = ReadCamera(message.K[1], model, message.dist[1]);
  for (int i = 0; i < 9; ++i) calibration.T_rawright_rawleft.linear()(i / 3, i % 3) = message.R_right_left[i];
  calibration.T_rawright_rawleft.translation() = ReadVector(message.t_right_left);
  if (!IsUnknownPose(message.body_from_left_quat)) {
    calibration.T_body_rawleft = ReadPose(message.body_from_left_pos, message.body_from_left_quat);
    if (!calibration.T_body_rawleft) return std::nullopt;
  }
  if (!IsUnknownPose(message.body_from_imu_quat)) {
    calibration.T_body_imu = ReadPose(message.body_from_imu_pos, message.body_from_imu_quat);
    if (!calibration.T_body_imu) return std::nullopt;
  }
  if (!AllFinite(message.imu_noise)) return std::nullopt;
  calibration.imu_noise = {message.imu_noise[0], message.imu_noise[1], message.imu_noise[2],
                           message.imu_noise[3]};
  return calibration;
}

}  // namespace terrace
