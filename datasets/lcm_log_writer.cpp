// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/lcm_log_writer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/sensor_codec.h"

namespace terrace {

LcmLogWriter::LcmLogWriter(const std::filesystem::path& path, StereoCalibration calibration,
                           std::vector<TimedPose> true_poses, ImageEncoding encoding, ChannelConfig channels)
    : log_(path),
      calibration_(std::move(calibration)),
      true_poses_(std::move(true_poses)),
      encoding_(encoding),
      channels_(std::move(channels)) {}

void LcmLogWriter::Add(const SensorFrame& frame) {
  constexpr std::chrono::seconds kCalibrationPeriod(1);
  const Timestamp t_capture = frame.pair.t_capture;
  if (!t_calibration_ || t_capture - *t_calibration_ >= kCalibrationPeriod) {
    // The first one goes in front of everything, also of samples from before the first frame.
    Timestamp t = t_capture;
    if (!t_calibration_ && !frame.samples.imu.empty()) t = std::min(t, frame.samples.imu.front().t);
    if (!t_calibration_ && !frame.samples.priors.empty()) t = std::min(t, frame.samples.priors.front().t);
    Collect(t, channels_.calibration, ToMessage(calibration_, t));
    t_calibration_ = t_capture;
  }
  for (const ImuSample& sample : frame.samples.imu) Collect(sample.t, channels_.imu, ToMessage(sample));
  for (const BodyPrior& prior : frame.samples.priors)
    Collect(prior.t, channels_.body_prior, ToMessage(prior));
  CollectTruePosesUpTo(t_capture);
  Collect(t_capture, channels_.images, ToMessage(frame.pair, encoding_));
  WriteCollected();
}

void LcmLogWriter::Finish() {
  if (!true_poses_.empty()) CollectTruePosesUpTo(true_poses_.back().t);
  WriteCollected();
  log_.Close();
}

template <typename Message>
void LcmLogWriter::Collect(Timestamp t, const std::string& channel, const Message& message) {
  Event event{t.utime(), &channel,
              std::vector<std::uint8_t>(static_cast<std::size_t>(message.getEncodedSize()))};
  message.encode(event.data.data(), 0, static_cast<int>(event.data.size()));
  collected_.push_back(std::move(event));
}

void LcmLogWriter::CollectTruePosesUpTo(Timestamp t) {
  for (; next_true_pose_ < true_poses_.size() && true_poses_[next_true_pose_].t <= t; ++next_true_pose_) {
    const TimedPose& pose = true_poses_[next_true_pose_];
    Collect(pose.t, channels_.true_pose, ToMessage(pose.t, pose.T_world_frame));
  }
}

void LcmLogWriter::WriteCollected() {
  // Stable: what shares a microsecond keeps its order, images last.
  std::stable_sort(collected_.begin(), collected_.end(),
                   [](const Event& a, const Event& b) { return a.utime < b.utime; });
  for (const Event& event : collected_) log_.Write(event.utime, *event.channel, event.data);
  collected_.clear();
}

std::vector<TimedPose> TruePosesForLog(const TrueTrajectory& truth, const StereoCalibration& calibration) {
  const bool rectified_differs = truth.frame == TruthFrame::kRectifiedLeft && !calibration.rectified();
  const bool body_unknown = truth.frame == TruthFrame::kBody && !calibration.T_body_rawleft;
  if (rectified_differs || body_unknown) return {};
  std::vector<TimedPose> poses = truth.poses;
  if (truth.frame != TruthFrame::kBody && calibration.T_body_rawleft) {
    const Eigen::Isometry3d T_rawleft_body = calibration.T_body_rawleft->inverse();
    for (TimedPose& pose : poses) pose.T_world_frame = pose.T_world_frame * T_rawleft_body;
  }
  return poses;
}

}  // namespace terrace
