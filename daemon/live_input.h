// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <lcm/lcm-cpp.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "core/status.h"
#include "daemon/frame_assembler.h"
#include "daemon/live_config.h"
#include "daemon/stamp_pace.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Listens to images, calibration, IMU, priors, commands, repairs and requests on LCM and makes sensor frames
/// of them. Works inside lcm.handle(): its handlers check, decode, queue and return, and nothing throws out
/// of them. `lcm` must outlive it.
class LiveInput {
 public:
  using OnCommand = std::function<void(const command_v1_t&)>;
  using OnRepair = std::function<void(const terrain_repair_v1_t&)>;
  using OnRequest = std::function<void(const terrain_request_v1_t&)>;

  /// @param calibration  known beforehand; none: it comes as a message
  LiveInput(lcm::LCM* lcm, const ChannelConfig& channels, const LiveConfig& config,
            std::optional<StereoCalibration> calibration, OnCommand on_command, OnRepair on_repair,
            OnRequest on_request);
  ~LiveInput();
  LiveInput(const LiveInput&) = delete;
  LiveInput& operator=(const LiveInput&) = delete;

  /// Of the rig; the first one that makes sense stays, unless it is refused.
  const std::optional<StereoCalibration>& calibration() const { return calibration_; }
  /// The calibration that came does not fit what is configured: the next one is waited for.
  void RefuseCalibration(const std::string& problem);
  /// Why what came as a calibration is not used, for the status; empty: nothing has come.
  std::string calibration_problem() const;

  /// The next frame that is complete. Frames are thrown away as long as there is no calibration.
  std::optional<SensorFrame> NextReady();
  /// The next frame whether complete or not: for the end.
  std::optional<SensorFrame> NextAny();

  /// Since the last pair arrived, or since the start.
  std::chrono::nanoseconds silence() const {
    return std::chrono::steady_clock::now() - images_.t_last.value_or(start_);
  }
  /// How each input fares; rates are over the time since the last call.
  std::vector<InputStatus> TakeInputs();

  std::int64_t num_bad_frames() const { return num_bad_frames_; }
  /// The newest calibration that came is another one than that in use.
  bool calibration_has_changed() const { return calibration_has_changed_; }
  /// Why the newest images that came were not taken; empty: they were, or none have come.
  const std::string& why_no_images() const { return images_.why_not; }
  /// By how much the clock of the IMU is ahead of that of the images, where that is too much to be of one
  /// clock.
  std::optional<std::chrono::nanoseconds> imu_clock_ahead() const { return assembler_.imu_clock_ahead(); }
  std::int64_t num_decode_errors() const { return num_decode_errors_; }
  std::int64_t num_time_jumps() const { return assembler_.num_time_jumps(); }
  std::int64_t num_imu_gaps() const { return assembler_.num_imu_gaps(); }

 private:
  using Buffer = const lcm::ReceiveBuffer;
  using Clock = std::chrono::steady_clock;

  /// What one channel has brought.
  struct Input {
    std::string name;
    std::string channel;
    std::int64_t num_messages = 0;
    std::int64_t num_bad = 0;
    std::int64_t num_in_window = 0;
    std::optional<Clock::time_point> t_last;  // of the newest good one
    std::string why_not;                      // the newest was not taken; empty: it was
    StampPace pace;
  };

  void OnImages(Buffer* buffer, const std::string& channel);
  void OnCalibration(Buffer* buffer, const std::string& channel);
  void OnImu(Buffer* buffer, const std::string& channel);
  void OnBodyPrior(Buffer* buffer, const std::string& channel);
  void OnBodyPose(Buffer* buffer, const std::string& channel);
  void OnCommandMessage(Buffer* buffer, const std::string& channel);
  void OnRepairMessage(Buffer* buffer, const std::string& channel);
  void OnRequestMessage(Buffer* buffer, const std::string& channel);
  template <typename Message, typename Use>
  void Decode(Input* input, Buffer* buffer, Use use);
  static void RequireUsualPace(Input* input, Timestamp stamp);
  template <auto method>
  void Listen(const Input& input, int capacity);
  void CheckSize(SensorFrame* frame);

  lcm::LCM* const lcm_;
  const PriorKind body_pose_kind_;
  const OnCommand on_command_;
  const OnRepair on_repair_;
  const OnRequest on_request_;
  std::optional<StereoCalibration> calibration_;
  std::string content_hash_;  // of the calibration message in use
  std::string calibration_problem_;
  bool calibration_has_changed_ = false;
  FrameAssembler assembler_;
  std::vector<lcm::Subscription*> subscriptions_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point window_start_ = start_;
  Input images_;
  Input calibrations_;
  Input imu_;
  Input body_prior_;
  Input body_pose_;
  Input command_;
  Input repair_;
  Input request_;
  std::int64_t num_bad_frames_ = 0;
  std::int64_t num_decode_errors_ = 0;
};

}  // namespace terrace
