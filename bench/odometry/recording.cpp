// SPDX-License-Identifier: BSD-3-Clause
#include "recording.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include "datasets/sequence.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

/// True poses of the rectified left camera; what a device tracked itself counts as the truth where there is
/// no other.
std::map<std::int64_t, Eigen::Isometry3d> ReadTruth(const std::filesystem::path& path,
                                                    const Eigen::Matrix3d& R_rect_raw) {
  std::map<std::int64_t, Eigen::Isometry3d> truth;
  std::string line;
  const bool by_device = !std::filesystem::exists(path / "groundtruth_tum.txt");
  if (std::ifstream tum(path / (by_device ? "zed_tracking.tum" : "groundtruth_tum.txt")); tum) {
    while (std::getline(tum, line)) {
      std::istringstream in(line);
      double t, x, y, z, qx, qy, qz, qw;
      if (!(in >> t >> x >> y >> z >> qx >> qy >> qz >> qw)) continue;
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation() << x, y, z;
      T.linear() =
          Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix() * R_rect_raw.transpose();
      truth[std::llround(t * 1e6)] = T;
    }
  } else if (std::ifstream poses(path / "poses.txt"); poses) {
    std::ifstream times(path / "times.txt");
    double t;
    while (times >> t && std::getline(poses, line)) {
      std::istringstream in(line);
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) in >> T.matrix()(r, c);
      truth[std::llround(t * 1e6)] = T;
    }
  }
  return truth;
}

void Append(const SensorSamples& samples, SensorSamples& to) {
  to.imu.insert(to.imu.end(), samples.imu.begin(), samples.imu.end());
  to.priors.insert(to.priors.end(), samples.priors.begin(), samples.priors.end());
}

}  // namespace

Recording LoadRecording(const std::filesystem::path& path) {
  Recording recording;
  recording.name = path.filename();
  const auto sequence = OpenSequence(path);
  const StereoCalibration& calibration = sequence->info().calibration;
  const Rectifier rectifier(calibration);
  recording.camera = rectifier.camera();
  recording.mounting.imu_noise = calibration.imu_noise;
  if (calibration.T_body_rawleft) {
    Eigen::Isometry3d T_rawleft_left = Eigen::Isometry3d::Identity();
    T_rawleft_left.linear() = rectifier.R_rect_raw().transpose();
    recording.mounting.T_body_left = *calibration.T_body_rawleft * T_rawleft_left;
    if (calibration.T_body_imu)
      recording.mounting.T_left_imu = recording.mounting.T_body_left->inverse() * *calibration.T_body_imu;
  }
  while (auto frame = sequence->Next()) {
    StereoFrame pair;
    pair.frame_id = frame->frame_id;
    pair.t_capture = frame->pair.t_capture;
    if (frame->pair.problem.empty()) {
      pair = rectifier.Rectify(frame->frame_id, frame->pair);
      pair.left = pair.left.clone();
      pair.right = pair.right.clone();
    }
    recording.frames.push_back(pair);
    recording.samples.push_back(frame->samples);
  }
  recording.truth = ReadTruth(path, rectifier.R_rect_raw());
  return recording;
}

Recording EveryNth(const Recording& recording, int n) {
  Recording fewer = recording;
  fewer.frames.clear();
  fewer.samples.clear();
  SensorSamples pending;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    Append(recording.samples[i], pending);
    if (i % static_cast<std::size_t>(n) != 0) continue;
    fewer.frames.push_back(recording.frames[i]);
    fewer.frames.back().frame_id = static_cast<FrameId>(fewer.frames.size()) - 1;
    fewer.samples.push_back(std::move(pending));
    pending = {};
  }
  return fewer;
}

Recording ThereAndBack(const Recording& recording) {
  Recording both = recording;
  const Timestamp t_end = recording.frames.back().t_capture;
  for (std::size_t i = recording.frames.size() - 1; i-- > 0;) {
    StereoFrame frame = recording.frames[i];
    const auto truth = recording.truth.find(std::llround(static_cast<double>(frame.t_capture.ns) * 1e-3));
    frame.frame_id = static_cast<FrameId>(both.frames.size());
    frame.t_capture = t_end + (t_end - frame.t_capture);
    if (truth != recording.truth.end())
      both.truth[std::llround(static_cast<double>(frame.t_capture.ns) * 1e-3)] = truth->second;
    both.frames.push_back(std::move(frame));
    both.samples.emplace_back();
  }
  return both;
}

}  // namespace terrace
