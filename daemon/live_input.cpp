// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_input.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/print.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/sensor_codec.h"
#include "lcmtypes/subscribe.h"

namespace terrace {
namespace {

// Messages that LCM keeps for us between two calls of handle(); the newest are lost when there are more.
constexpr int kImageCapacity = 4;
constexpr int kSampleCapacity = 2000;
constexpr int kOtherCapacity = 30;

/// What arrived instead of a message that can be decoded.
std::string WhyNot(const lcm::ReceiveBuffer& buffer, std::uint64_t fingerprint, const char* type) {
  constexpr std::size_t kFingerprintBytes = 8;
  if (buffer.data_size < kFingerprintBytes) return "too short for a message";
  std::uint64_t came = 0;
  for (std::size_t i = 0; i < kFingerprintBytes; ++i)
    came = came << 8 | static_cast<const std::uint8_t*>(buffer.data)[i];
  if (came == fingerprint) return std::string("a damaged ") + type;
  return Printed("another type than %s: its fingerprint is %016llx, must be %016llx", type,
                 static_cast<unsigned long long>(came), static_cast<unsigned long long>(fingerprint));
}

std::string StrangeTime(std::int64_t utime) {
  constexpr std::int64_t kYear2200_us = 7'258'118'400'000'000;
  if (utime / 1000 < kYear2200_us && utime > kYear2200_us)
    return "utime seems to be in nanoseconds, must be microseconds: divide it by 1000";
  return "utime cannot be, must be microseconds since 1970";
}

std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

LiveInput::LiveInput(lcm::LCM* lcm, const ChannelConfig& channels, const LiveConfig& config,
                     std::optional<StereoCalibration> calibration, OnCommand on_command, OnRepair on_repair,
                     OnRequest on_request)
    : lcm_(lcm),
      body_pose_kind_(channels.body_pose_prior()),
      on_command_(std::move(on_command)),
      on_repair_(std::move(on_repair)),
      on_request_(std::move(on_request)),
      calibration_(std::move(calibration)),
      assembler_(config),
      images_{"images", channels.images},
      calibrations_{"calibration", calibration_ ? std::string() : channels.calibration},
      imu_{"imu", channels.imu},
      body_prior_{"body_prior", channels.body_prior},
      body_pose_{"body_pose", channels.body_pose},
      command_{"command", channels.command},
      repair_{"repair", channels.repair},
      request_{"request", channels.request} {
  Listen<&LiveInput::OnImages>(images_, kImageCapacity);
  Listen<&LiveInput::OnCalibration>(calibrations_, kOtherCapacity);
  Listen<&LiveInput::OnImu>(imu_, kSampleCapacity);
  Listen<&LiveInput::OnBodyPrior>(body_prior_, kSampleCapacity);
  Listen<&LiveInput::OnBodyPose>(body_pose_, kSampleCapacity);
  Listen<&LiveInput::OnCommandMessage>(command_, kOtherCapacity);
  Listen<&LiveInput::OnRepairMessage>(repair_, kOtherCapacity);
  Listen<&LiveInput::OnRequestMessage>(request_, kOtherCapacity);
}

LiveInput::~LiveInput() {
  for (lcm::Subscription* subscription : subscriptions_) lcm_->unsubscribe(subscription);
}

/// An input without a channel is none.
template <auto method>
void LiveInput::Listen(const Input& input, int capacity) {
  if (input.channel.empty()) return;
  lcm::Subscription* subscription = Subscribe<method>(lcm_, input.channel, this);
  if (subscription == nullptr) throw std::runtime_error("cannot listen on " + input.channel);
  subscription->setQueueCapacity(capacity);
  subscriptions_.push_back(subscription);
}

template <typename Message, typename Use>
void LiveInput::Decode(Input* input, Buffer* buffer, Use use) {
  ++input->num_messages;
  ++input->num_in_window;
  std::string why_not;
  try {
    const std::optional<Message> message = SafeDecode<Message>(buffer->data, buffer->data_size);
    if (!message) {
      why_not = WhyNot(*buffer, static_cast<std::uint64_t>(Message::getHash()), Message::getTypeName());
    } else if (!use(*message)) {
      why_not = "a value in it cannot be: time stamps must be microseconds since 1970, poses finite";
    }
  } catch (const std::exception& error) {
    why_not = error.what();
  }
  if (why_not.empty()) {
    input->t_last = Clock::now();
  } else {
    ++input->num_bad;
    ++num_decode_errors_;
    if (why_not != input->why_not) spdlog::warn("messages on {} are not taken: {}", input->channel, why_not);
  }
  input->why_not = why_not;
}

void LiveInput::RequireUsualPace(Input* input, Timestamp stamp) {
  const double factor = input->pace.Add(stamp, Clock::now());
  if (factor != 1.0) throw std::runtime_error(SentenceAboutPace(factor));
}

std::vector<InputStatus> LiveInput::TakeInputs() {
  const auto now = Clock::now();
  const double window_s = std::max(1e-3, std::chrono::duration<double>(now - window_start_).count());
  window_start_ = now;
  std::vector<InputStatus> inputs;
  for (Input* input :
       {&images_, &calibrations_, &imu_, &body_prior_, &body_pose_, &command_, &repair_, &request_}) {
    if (input->channel.empty()) continue;
    InputStatus status{input->name, input->channel, input->num_messages, input->num_bad, 0.0, std::nullopt};
    status.rate_hz = static_cast<double>(std::exchange(input->num_in_window, 0)) / window_s;
    if (input->t_last)
      status.age_ms = std::chrono::duration<double, std::milli>(now - *input->t_last).count();
    inputs.push_back(std::move(status));
  }
  return inputs;
}

void LiveInput::OnImages(Buffer* buffer, const std::string&) {
  Decode<images_t>(&images_, buffer, [this](const images_t& message) {
    const std::optional<Timestamp> t_capture = CaptureTime(message);
    if (!t_capture) throw std::runtime_error(StrangeTime(message.utime));
    RequireUsualPace(&images_, *t_capture);
    if (calibration_) assembler_.Add(FromMessage(message), Clock::now());
    return true;
  });
}

void LiveInput::OnCalibration(Buffer* buffer, const std::string& channel) {
  Decode<calibration_v1_t>(&calibrations_, buffer, [&](const calibration_v1_t& message) {
    if (calibration_) {
      calibration_has_changed_ = message.content_hash != content_hash_;
      return true;
    }
    std::optional<StereoCalibration> calibration = FromMessage(message);
    if (!calibration)
      throw std::runtime_error("a pose or noise in it is none, or its model is no lens model");
    calibration->name = channel + " (" + message.name + ")";
    std::string problem;
    for (const std::string& sentence : calibration->Problems())
      problem += (problem.empty() ? "" : "; ") + sentence;
    if (!problem.empty()) {
      RefuseCalibration(problem);
      return true;
    }
    calibration_ = std::move(calibration);
    content_hash_ = message.content_hash;
    return true;
  });
}

std::string LiveInput::calibration_problem() const {
  if (calibration_) return "";
  if (calibrations_.why_not.empty()) return calibration_problem_;
  return "messages on " + calibrations_.channel + " are not taken: " + calibrations_.why_not;
}

void LiveInput::RefuseCalibration(const std::string& problem) {
  calibration_.reset();
  // It comes once a second.
  if (problem != calibration_problem_) spdlog::error("the calibration cannot be used: {}", problem);
  calibration_problem_ = problem;
}

void LiveInput::OnImu(Buffer* buffer, const std::string&) {
  Decode<imu_v1_t>(&imu_, buffer, [this](const imu_v1_t& message) {
    const std::optional<ImuSample> sample = FromMessage(message);
    if (sample) RequireUsualPace(&imu_, sample->t);
    if (sample) assembler_.Add(*sample, std::chrono::steady_clock::now());
    return sample.has_value();
  });
}

void LiveInput::OnBodyPrior(Buffer* buffer, const std::string&) {
  Decode<body_prior_v1_t>(&body_prior_, buffer, [this](const body_prior_v1_t& message) {
    const std::optional<BodyPrior> prior = FromMessage(message);
    if (prior) RequireUsualPace(&body_prior_, prior->t);
    if (prior) assembler_.Add(*prior);
    return prior.has_value();
  });
}

void LiveInput::OnBodyPose(Buffer* buffer, const std::string&) {
  Decode<pose_t>(&body_pose_, buffer, [this](const pose_t& message) {
    const std::optional<BodyPrior> prior = PriorFromPose(message, body_pose_kind_);
    if (prior) RequireUsualPace(&body_pose_, prior->t);
    if (prior) assembler_.Add(*prior);
    return prior.has_value();
  });
}

void LiveInput::OnCommandMessage(Buffer* buffer, const std::string&) {
  Decode<command_v1_t>(&command_, buffer, [this](const command_v1_t& message) {
    on_command_(message);
    return true;
  });
}

void LiveInput::OnRepairMessage(Buffer* buffer, const std::string&) {
  Decode<terrain_repair_v1_t>(&repair_, buffer, [this](const terrain_repair_v1_t& message) {
    on_repair_(message);
    return true;
  });
}

void LiveInput::OnRequestMessage(Buffer* buffer, const std::string&) {
  Decode<terrain_request_v1_t>(&request_, buffer, [this](const terrain_request_v1_t& message) {
    on_request_(message);
    return true;
  });
}

std::optional<SensorFrame> LiveInput::NextReady() {
  if (const auto set_by = assembler_.TakeClockChange(); set_by.count() != 0)
    spdlog::warn(
        "the clock of the images was set by {:.1f} s: a new map begins unless the place is recognised",
        Seconds(set_by));
  std::optional<SensorFrame> frame = assembler_.TakeReady(std::chrono::steady_clock::now());
  if (frame) CheckSize(&*frame);
  return frame;
}

std::optional<SensorFrame> LiveInput::NextAny() {
  std::optional<SensorFrame> frame = assembler_.TakeAny();
  if (frame) CheckSize(&*frame);
  return frame;
}

void LiveInput::CheckSize(SensorFrame* frame) {
  StereoPair& pair = frame->pair;
  for (const GrayImage* image : {&pair.left, &pair.right}) {
    if (!pair.problem.empty()) break;
    if (image->width == calibration_->width && image->height == calibration_->height) continue;
    pair.problem = "image of " + SizeText(image->width, image->height) + ", must be " +
                   SizeText(calibration_->width, calibration_->height) + " as " + calibration_->name +
                   " says";
  }
  if (pair.problem.empty()) return;
  pair.left = pair.right = {};
  ++num_bad_frames_;
}

}  // namespace terrace
