// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/status_reporter.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include <opencv2/core.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "daemon/version.h"
#include "lcmtypes/status_codec.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::int64_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

/// From the images being taken to now, when their clock is ours; else since they were handed over.
double AgeMs(Timestamp t_capture, double handover_ms) {
  constexpr double kMaxPlausibleMs = 10e3;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto age = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - t_capture.ns;
  const double age_ms = 1e-6 * static_cast<double>(age);
  return age_ms >= 0.0 && age_ms < kMaxPlausibleMs ? age_ms : handover_ms;
}

/// Share of pixels with a disparity.
double DenseRatio(const DisparityImage& disparity) {
  const cv::Mat1f& d = disparity.disparity_px;
  // NaN is the one value that differs from itself.
  return d.empty() ? 0.0 : static_cast<double>(cv::countNonZero(d == d)) / static_cast<double>(d.total());
}

}  // namespace

StatusReporter::StatusReporter(lcm::LCM* lcm, std::string channel, InputSource source,
                               std::string config_hash, double deadline_ms)
    : lcm_(lcm),
      channel_(std::move(channel)),
      config_hash_(std::move(config_hash)),
      source_(source),
      deadline_ms_(deadline_ms),
      start_(Clock::now()),
      window_start_(start_),
      cpu_s_(CpuSeconds()) {}

void StatusReporter::AddFrameIn() {
  const std::lock_guard lock(mutex_);
  ++num_in_;
}

void StatusReporter::AddPose(const PoseEstimate& pose) {
  const std::lock_guard lock(mutex_);
  if (pose.status == TrackingStatus::kLost) ++num_lost_;
  last_pose_ = pose;
}

void StatusReporter::AddResult(const FrameResult& result) {
  const double age_ms = AgeMs(result.pose.t_capture, result.latency_ms.value_or(0.0));
  const std::lock_guard lock(mutex_);
  ++num_out_;
  ages_ms_.push_back(age_ms);
  if (age_ms > deadline_ms_) ++num_deadline_missed_;
  last_ = result;
}

Status StatusReporter::Take(DaemonState state, StageMeters* meters) {
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  const double window_s = std::max(1e-3, std::chrono::duration<double>(now - window_start_).count());
  const double cpu_s = CpuSeconds();
  Status status;
  status.t.ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                    std::chrono::system_clock::now().time_since_epoch())
                    .count();
  status.seq = seq_++;
  status.version = kVersion;
  status.config_hash = config_hash_;
  status.uptime_ms = std::chrono::duration_cast<std::chrono::milliseconds>(now - start_).count();
  status.state = state;
  status.source = source_;
  status.window_s = window_s;
  status.fps_in = static_cast<double>(num_in_) / window_s;
  status.fps_out = static_cast<double>(num_out_) / window_s;
  status.age_p50_ms = Quantile(ages_ms_, 0.5);
  status.age_p99_ms = Quantile(ages_ms_, 0.99);
  status.age_max_ms = Quantile(ages_ms_, 1.0);
  status.num_deadline_missed = num_deadline_missed_;
  status.num_lost = num_lost_;
  status.tracking = last_pose_.status;
  status.reason = last_pose_.reason;
  status.reason_code = last_pose_.reason_code;
  // What the pair of images lacks shows after the pose is out.
  if (status.reason.empty()) status.reason = last_.pose.reason;
  if (!status.reason.empty() && status.reason_code == ReasonCode::kNone)
    status.reason_code = ReasonCode::kOther;
  status.epoch = last_pose_.epoch;
  status.num_matches = last_pose_.num_matches;
  status.num_inliers = last_pose_.num_inliers;
  status.rms_px = last_pose_.rms_px;
  status.vertical_disparity_px = last_pose_.vertical_disparity_px;
  if (last_.disparity) status.dense_ratio = DenseRatio(*last_.disparity);
  if (last_.change.map) {
    status.gravity_source = last_.change.map->gravity.source;
    status.num_regions = static_cast<int>(last_.change.map->regions.size());
    if (state == DaemonState::kRunning &&
        (last_pose_.status != TrackingStatus::kTracking || !last_pose_.reason.empty())) {
      status.state = DaemonState::kDegraded;
    }
  }
  status.num_octree_nodes = last_.change.map_cells;
  status.map_bytes = last_.change.map_bytes;
  status.rss_bytes = ResidentBytes();
  status.cpu = (cpu_s - cpu_s_) / window_s;
  if (meters != nullptr) status.stages = meters->TakeWindows();

  window_start_ = now;
  cpu_s_ = cpu_s;
  num_in_ = num_out_ = 0;
  ages_ms_.clear();
  return status;
}

void StatusReporter::Send(const Status& status) {
  constexpr std::size_t kRemembered = 8;
  const status_v1_t message = ToMessage(status);
  sent_.push_back(Timestamp::FromMicroseconds(message.utime));
  if (sent_.size() > kRemembered) sent_.pop_front();
  lcm_->publish(channel_, &message);
}

}  // namespace terrace
