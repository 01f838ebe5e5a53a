// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threaded_pipeline.h"

#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "daemon/result_writer.h"
#include "test/daemon/tiny_world.h"

namespace terrace {
namespace {

PipelineConfig TinyConfig(bool use_prior = false) {
  PipelineConfig config;
  config.stereo.max_disparity_px = use_prior ? 128 : 64;  // enough to be narrowed
  config.stereo.use_prior = use_prior;
  return config;
}

/// Every frame's map and pose as text, so that a difference anywhere shows.
std::string Describe(const FrameResult& result) {
  std::ostringstream text;
  text.precision(17);
  text << result.pose.frame_id << ' ' << Name(result.pose.status) << ' ' << result.pose.reason << '\n'
       << result.pose.T_world_left.matrix() << '\n'
       << TerrainMapJson(*result.change.map);
  return text.str();
}

std::vector<std::string> InOneThread(const std::vector<SensorFrame>& frames, const PipelineConfig& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  Pipeline pipeline(config, test::TinyCalibration(), {});
  std::vector<std::string> results;
  for (const SensorFrame& frame : frames) results.push_back(Describe(pipeline.Process(frame)));
  return results;
}

std::vector<std::string> OnThreads(const std::vector<SensorFrame>& frames, const PipelineConfig& config,
                                   std::size_t num_threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, num_threads);
  Pipeline pipeline(config, test::TinyCalibration(), {});
  std::vector<std::string> results;
  ThreadedPipeline threads(&pipeline, WhenFull::kWait, [&](const SensorFrame&, const FrameResult& result) {
    results.push_back(Describe(result));
  });
  for (const SensorFrame& frame : frames) EXPECT_TRUE(threads.Push(frame));
  threads.Finish();
  return results;
}

TEST(ThreadedPipelineTest, GivesTheSameBitsAsOneThreadAndMapsTheFloor) {
  std::vector<SensorFrame> frames = test::TinySequence(10);
  frames[5].pair = {
      .t_capture = frames[5].pair.t_capture, .left = {}, .right = {}, .problem = "5.png: is truncated"};
  const std::vector<std::string> expected = InOneThread(frames, TinyConfig());
  EXPECT_EQ(OnThreads(frames, TinyConfig(), 1), expected);
  EXPECT_EQ(OnThreads(frames, TinyConfig(), 3), expected);
  EXPECT_NE(expected[5].find("bridging 5.png: is truncated"), std::string::npos) << expected[5];
  EXPECT_NE(expected.back().find("\"outline\""), std::string::npos) << "the map is empty";
}

TEST(PipelineTest, BuildsNothingOnAPoseInDoubt) {
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
  for (const bool in_doubt : {true, false}) {
    const SensorFrame sensors = test::TinySequence(1)[0];
    const StereoFramePtr frame = pipeline.Rectify(sensors);
    const auto disparity = pipeline.Match(frame);
    TrackedPose tracked;
    tracked.pose.status = TrackingStatus::kTracking;
    tracked.pose.trusted = !in_doubt;
    if (in_doubt) tracked.pose.reason = "another motion explains nearly as much";
    const FrameResult result = pipeline.Map(disparity, tracked);
    EXPECT_EQ(result.change.map_cells == 0, in_doubt);
    EXPECT_EQ(result.pose.reason.empty(), !in_doubt);
  }
}

TEST(ThreadedPipelineTest, GivesTheSameBitsWhereTheMatcherUsesAPrior) {
  const std::vector<SensorFrame> frames = test::TinySequence(8);
  const PipelineConfig config = TinyConfig(true);
  const std::vector<std::string> expected = InOneThread(frames, config);
  EXPECT_EQ(OnThreads(frames, config, 1), expected);
  EXPECT_EQ(OnThreads(frames, config, 3), expected);
}

TEST(ThreadedPipelineTest, WhatASinkThrowsEndsThePipelineAndReachesFinish) {
  const std::vector<SensorFrame> frames = test::TinySequence(1);
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
  ThreadedPipeline threads(&pipeline, WhenFull::kWait, [](const SensorFrame&, const FrameResult&) {
    throw std::runtime_error("disk full");
  });
  SensorFrame frame = frames[0];
  // Far more than all queues hold: a producer must be refused sooner or later, not left waiting.
  for (int i = 0; i < 100 && threads.Push(frame); ++i)
    frame.pair.t_capture = frame.pair.t_capture + std::chrono::seconds(1);
  EXPECT_THROW(threads.Finish(), std::runtime_error);
}

TEST(ThreadedPipelineTest, TheNewestFrameWinsLiveAndNoSampleIsLost) {
  std::vector<SensorFrame> frames = test::TinySequence(1);
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
  std::int64_t num_frames = 0;
  std::int64_t num_samples = 0;
  Timestamp newest;
  ThreadedPipeline threads(&pipeline, WhenFull::kDropOldest,
                           [&](const SensorFrame& sensors, const FrameResult&) {
                             ++num_frames;
                             num_samples += static_cast<std::int64_t>(sensors.samples.imu.size());
                             newest = sensors.pair.t_capture;
                           });
  const int num_pushed = 60;
  for (int i = 0; i < num_pushed; ++i) {
    SensorFrame frame = frames[0];
    frame.pair.t_capture = frame.pair.t_capture + std::chrono::milliseconds(100 * i);
    frame.samples.imu.push_back({.t = frame.pair.t_capture, .accel = {0, 0, 9.81}});
    EXPECT_TRUE(threads.Push(frame));
  }
  threads.Finish();
  EXPECT_EQ(num_frames + threads.num_dropped(), num_pushed);
  EXPECT_GT(threads.num_dropped(), 0) << "60 frames at once must be more than the pipeline takes";
  EXPECT_EQ(num_samples, num_pushed);
  EXPECT_EQ(newest, frames[0].pair.t_capture + std::chrono::milliseconds(100 * (num_pushed - 1)));
}

}  // namespace
}  // namespace terrace
