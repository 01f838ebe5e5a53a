// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_input.h"

#include <exception>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "lcmtypes/codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"

namespace terrace {
namespace {

// Messages that LCM keeps for us between two calls of handle(); the newest are lost when there are more.
constexpr int kImageCapacity = 4;
constexpr int kSampleCapacity = 2000;
constexpr int kOtherCapacity = 30;

std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

LiveInput::LiveInput(lcm::LCM* lcm, const ChannelConfig& channels, const LiveConfig& config,
                     std::optional<StereoCalibration> calibration, OnCommand on_command)
    : lcm_(lcm),
      body_pose_kind_(channels.body_pose_prior()),
      on_command_(std::move(on_command)),
      calibration_(std::move(calibration)),
      assembler_(config) {
  Listen<&LiveInput::OnImages>(channels.images, kImageCapacity);
  if (!calibration_) Listen<&LiveInput::OnCalibration>(channels.calibration, kOtherCapacity);
  Listen<&LiveInput::OnImu>(channels.imu, kSampleCapacity);
  Listen<&LiveInput::OnBodyPrior>(channels.body_prior, kSampleCapacity);
  if (!channels.body_pose.empty()) Listen<&LiveInput::OnBodyPose>(channels.body_pose, kSampleCapacity);
  Listen<&LiveInput::OnCommandMessage>(channels.command, kOtherCapacity);
}

LiveInput::~LiveInput() {
  for (lcm::Subscription* subscription : subscriptions_) lcm_->unsubscribe(subscription);
}

template <auto method>
void LiveInput::Listen(const std::string& channel, int capacity) {
  lcm::Subscription* subscription = Subscribe<method>(lcm_, channel, this);
  if (subscription == nullptr) throw std::runtime_error("cannot listen on " + channel);
  subscription->setQueueCapacity(capacity);
  subscriptions_.push_back(subscription);
}

template <typename Message, typename Use>
void LiveInput::Decode(Buffer* buffer, Use use) {
  try {
    const std::optional<Message> message = SafeDecode<Message>(buffer->data, buffer->data_size);
    if (!message || !use(*message)) ++num_decode_errors_;
  } catch (const std::exception& error) {
    ++num_decode_errors_;
    spdlog::error("a message could not be used: {}", error.what());
  }
}

void LiveInput::OnImages(Buffer* buffer, const std::string&) {
  Decode<images_t>(buffer, [this](const images_t& message) {
    if (!CaptureTime(message)) return false;
    const auto now = std::chrono::steady_clock::now();
    pair_arrived_ = now;
    ++num_pairs_;
    if (calibration_) assembler_.Add(FromMessage(message), now);
    return true;
  });
}

void LiveInput::OnCalibration(Buffer* buffer, const std::string& channel) {
  Decode<calibration_v1_t>(buffer, [&](const calibration_v1_t& message) {
    if (calibration_) {
      if (message.content_hash != content_hash_ && !std::exchange(change_said_, true)) {
        spdlog::warn("the calibration on {} has changed; the one of before stays in use until a restart",
                     channel);
      }
      return true;
    }
    std::optional<StereoCalibration> calibration = FromMessage(message);
    if (!calibration) return false;
    calibration->name = channel + " (" + message.name + ")";
    std::string problem;
    for (const std::string& sentence : calibration->Problems())
      problem += (problem.empty() ? "" : "; ") + sentence;
    if (!problem.empty()) {
      if (problem != calibration_problem_) spdlog::error("the calibration cannot be used: {}", problem);
      calibration_problem_ = problem;
      return true;
    }
    calibration_problem_.clear();
    calibration_ = std::move(calibration);
    content_hash_ = message.content_hash;
    return true;
  });
}

void LiveInput::OnImu(Buffer* buffer, const std::string&) {
  Decode<imu_v1_t>(buffer, [this](const imu_v1_t& message) {
    const std::optional<ImuSample> sample = FromMessage(message);
    if (sample) assembler_.Add(*sample, std::chrono::steady_clock::now());
    return sample.has_value();
  });
}

void LiveInput::OnBodyPrior(Buffer* buffer, const std::string&) {
  Decode<body_prior_v1_t>(buffer, [this](const body_prior_v1_t& message) {
    const std::optional<BodyPrior> prior = FromMessage(message);
    if (prior) assembler_.Add(*prior);
    return prior.has_value();
  });
}

void LiveInput::OnBodyPose(Buffer* buffer, const std::string&) {
  Decode<pose_t>(buffer, [this](const pose_t& message) {
    const std::optional<BodyPrior> prior = PriorFromPose(message, body_pose_kind_);
    if (prior) assembler_.Add(*prior);
    return prior.has_value();
  });
}

void LiveInput::OnCommandMessage(Buffer* buffer, const std::string&) {
  Decode<command_v1_t>(buffer, [this](const command_v1_t& message) {
    on_command_(message);
    return true;
  });
}

std::optional<SensorFrame> LiveInput::NextReady() {
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
