// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_input.h"

#include <chrono>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/sensor_codec.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t kNsPerMs = 1'000'000;

StereoCalibration SomeCalibration() {
  StereoCalibration calibration;
  calibration.name = "test rig";
  calibration.width = 64;
  calibration.height = 48;
  calibration.left = calibration.right = {60, 60, 31.5, 23.5, DistortionModel::kRadialTangential, {}};
  calibration.T_rawright_rawleft.translation().x() = -0.1;
  return calibration;
}

images_t SomeImages(std::int64_t t_ns, int width = 64, ImageEncoding encoding = ImageEncoding::kRaw) {
  const GrayImage image{width, 48, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * 48, 7)};
  return ToMessage(StereoPair{{t_ns}, image, image, ""}, encoding);
}

class LiveInputTest : public testing::Test {
 protected:
  LiveInputTest() { Listen(std::nullopt); }

  void Listen(std::optional<StereoCalibration> calibration) {
    input_.emplace(
        &lcm_, channels_, config_, std::move(calibration),
        [this](const command_v1_t& command) { commands_.push_back(command.command); },
        [this](const terrain_repair_v1_t& repair) { repairs_.push_back(repair.have_seq); },
        [this](const terrain_request_v1_t& request) { requests_.push_back(request.request_id); });
  }

  template <typename Message>
  void Send(const std::string& channel, const Message& message) {
    lcm_.publish(channel, &message);
    HandleAll();
  }
  void SendBytes(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
    HandleAll();
  }
  void HandleAll() {
    while (lcm_.handleTimeout(0) > 0) {
    }
  }

  ChannelConfig channels_;
  LiveConfig config_;
  std::vector<int> commands_;
  std::vector<std::int64_t> repairs_;
  std::vector<std::int64_t> requests_;
  lcm::LCM lcm_{"memq://"};
  std::optional<LiveInput> input_;
};

TEST_F(LiveInputTest, CountsWhatEveryInputBringsAndSaysHowOldTheNewestIs) {
  const auto input_named = [](const std::vector<InputStatus>& inputs, const std::string& name) {
    const auto found =
        std::find_if(inputs.begin(), inputs.end(), [&](const InputStatus& i) { return i.name == name; });
    return found == inputs.end() ? InputStatus{} : *found;
  };
  Send(channels_.imu, ToMessage(ImuSample{{1'600'000'000'000'000'000}, {}, {0, 0, 9.81}}));
  Send(channels_.imu, ToMessage(ImuSample{{1'600'000'000'010'000'000}, {}, {0, 0, 9.81}}));
  SendBytes(channels_.imu, {1, 2, 3});
  std::vector<InputStatus> inputs = input_->TakeInputs();
  const InputStatus imu = input_named(inputs, "imu");
  EXPECT_EQ(imu.channel, channels_.imu);
  EXPECT_EQ(imu.num_messages, 3);
  EXPECT_EQ(imu.num_bad, 1);
  EXPECT_GT(imu.rate_hz, 0.0);
  ASSERT_TRUE(imu.age_ms);
  EXPECT_GE(*imu.age_ms, 0.0);
  EXPECT_FALSE(input_named(inputs, "images").age_ms) << "none has come";
  EXPECT_EQ(input_named(inputs, "body_pose").name, "") << "no channel is set for it";
  inputs = input_->TakeInputs();
  EXPECT_EQ(input_named(inputs, "imu").num_messages, 3);
  EXPECT_EQ(input_named(inputs, "imu").rate_hz, 0.0) << "nothing came since the last call";
}

TEST_F(LiveInputTest, PassesRepairsOn) {
  terrain_repair_v1_t repair{};
  repair.have_seq = 7;
  Send(channels_.repair, repair);
  EXPECT_EQ(repairs_, std::vector<std::int64_t>{7});
}

TEST_F(LiveInputTest, ThrowsFramesAwayUntilTheCalibrationHasCome) {
  Send(channels_.images, SomeImages(100 * kNsPerMs));
  EXPECT_FALSE(input_->NextReady());
  Send(channels_.calibration, ToMessage(SomeCalibration(), {0}));
  ASSERT_TRUE(input_->calibration());
  Send(channels_.images, SomeImages(200 * kNsPerMs, 64, ImageEncoding::kLossless));
  const auto frame = input_->NextReady();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pair.t_capture.ns, 200 * kNsPerMs);
  EXPECT_EQ(input_->num_bad_frames(), 0);
}

TEST_F(LiveInputTest, WaitsForACalibrationThatMakesSenseAndSaysWhatIsWrong) {
  StereoCalibration swapped = SomeCalibration();
  swapped.T_rawright_rawleft.translation().x() = 0.1;
  Send(channels_.calibration, ToMessage(swapped, {0}));
  EXPECT_FALSE(input_->calibration());
  EXPECT_THAT(input_->calibration_problem(), HasSubstr("swapped"));
  Send(channels_.calibration, ToMessage(SomeCalibration(), {0}));
  EXPECT_TRUE(input_->calibration());
  EXPECT_THAT(input_->calibration_problem(), IsEmpty());
}

TEST_F(LiveInputTest, GivesSamplesToTheirFrames) {
  Listen(SomeCalibration());
  Send(channels_.imu, ToMessage(ImuSample{{95 * kNsPerMs}, {1, 2, 3}, {4, 5, 6}}));
  Send(channels_.body_prior, ToMessage(BodyPrior{{96 * kNsPerMs}}));
  Send(channels_.images, SomeImages(100 * kNsPerMs));
  EXPECT_FALSE(input_->NextReady()) << "the IMU is not there yet";
  Send(channels_.imu, ToMessage(ImuSample{{100 * kNsPerMs}}));
  const auto frame = input_->NextReady();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->samples.imu.size(), 2u);
  EXPECT_EQ(frame->samples.priors.size(), 1u);
}

TEST_F(LiveInputTest, TakesPosesOfTheRobotForPriorsOnTheChannelThatIsSetForThem) {
  channels_.body_pose = "POSE_BODY";
  Listen(SomeCalibration());
  Send("POSE_BODY", ToMessage(Timestamp{90 * kNsPerMs}, Eigen::Isometry3d::Identity()));
  Send(channels_.images, SomeImages(100 * kNsPerMs));
  const auto frame = input_->NextReady();
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->samples.priors.size(), 1u);
  EXPECT_EQ(frame->samples.priors[0].kind, PriorKind::kLegOdometry);
}

TEST_F(LiveInputTest, PassesBadPairsOnAndCountsThem) {
  Listen(SomeCalibration());
  Send(channels_.images, SomeImages(100 * kNsPerMs, 32));
  Send(channels_.images, ToMessage(StereoPair{{200 * kNsPerMs}, {}, {}, "no light"}, ImageEncoding::kRaw));
  EXPECT_THAT(input_->NextReady()->pair.problem, HasSubstr("32x48"));
  EXPECT_THAT(input_->NextReady()->pair.problem, HasSubstr("no light"));
  EXPECT_EQ(input_->num_bad_frames(), 2);
}

TEST_F(LiveInputTest, SurvivesAndCountsWhatIsNoMessage) {
  const std::vector<std::uint8_t> rubbish(100, 0xed);
  for (const std::string& channel :
       {channels_.images, channels_.calibration, channels_.imu, channels_.body_prior, channels_.command}) {
    SendBytes(channel, rubbish);
    SendBytes(channel, {0});
  }
  SendBytes("SOMEONE_ELSE", rubbish);
  EXPECT_EQ(input_->num_decode_errors(), 10);
}

TEST_F(LiveInputTest, RefusesImagesAndSamplesWhoseTimesGoAThousandTimesTooSlowly) {
  Listen(SomeCalibration());
  constexpr int kNumPairs = 8;
  for (int i = 0; i < kNumPairs; ++i) {  // milliseconds where microseconds are meant
    Send(channels_.images, SomeImages(1'600'000'000'000'000 + i * 200'000));
    Send(channels_.imu, ToMessage(ImuSample{{1'600'000'000'000'000 + i * 200'000}, {}, {0, 0, 9.81}}));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  EXPECT_THAT(input_->why_no_images(), HasSubstr("with the factor 1000 they would be right"));
  EXPECT_GT(input_->num_decode_errors(), 0);
}

TEST_F(LiveInputTest, HandsCommandsOn) {
  command_v1_t command{};
  command.command = command_v1_t::PAUSE;
  Send(channels_.command, command);
  EXPECT_THAT(commands_, ElementsAre(command_v1_t::PAUSE));
}

}  // namespace
}  // namespace terrace
