// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threaded_pipeline.h"

#include <algorithm>
#include <future>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "results/map_file.h"
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
  std::vector<FrameId> poses;
  ThreadedPipeline threads(
      &pipeline, Pace::kEveryFrame, [&](const PoseEstimate& pose) { poses.push_back(pose.frame_id); },
      [&](const FrameResult& result) { results.push_back(Describe(result)); });
  for (const SensorFrame& frame : frames) EXPECT_TRUE(threads.Push(frame));
  threads.Finish();
  EXPECT_EQ(poses.size(), frames.size());
  EXPECT_TRUE(std::is_sorted(poses.begin(), poses.end()));
  return results;
}

/// So many frames see a place before the octree holds it for a surface.
constexpr int kFramesToBelieve = 6;

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
  for (const bool in_doubt : {true, false}) {
    Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
    std::int64_t map_cells = 0;
    for (const SensorFrame& sensors : test::TinySequence(kFramesToBelieve)) {
      const StereoFramePtr frame = pipeline.Rectify(sensors);
      const auto disparity = pipeline.Match(frame);
      TrackedPose tracked;
      tracked.pose.frame_id = sensors.frame_id;
      tracked.pose.status = TrackingStatus::kTracking;
      tracked.pose.trusted = !in_doubt;
      tracked.frame = frame;
      if (in_doubt) tracked.pose.reason = "another motion explains nearly as much";
      const FrameResult result = pipeline.Map(disparity, tracked);
      map_cells = result.change.map_cells;
      EXPECT_EQ(result.pose.reason.empty(), !in_doubt);
    }
    EXPECT_EQ(map_cells == 0, in_doubt);
  }
}

TEST(PipelineTest, PutsPosesInDoubtOnceTheTwoImagesAreSeenToShowDifferentThings) {
  const PipelineConfig config = TinyConfig();
  Pipeline pipeline(config, test::TinyCalibration(), {});
  constexpr int kFirstWrong = 2;
  for (SensorFrame& sensors : test::TinySequence(kFirstWrong + config.flow.feedback_lag_frames + 1)) {
    std::vector<std::uint8_t>& right = sensors.pair.right.data;
    if (sensors.frame_id >= kFirstWrong) std::reverse(right.begin(), right.end());
    const StereoFramePtr frame = pipeline.Rectify(sensors);
    const TrackedPose tracked = pipeline.Track(sensors, frame);
    pipeline.Map(pipeline.Match(frame), tracked);
    const bool known = sensors.frame_id >= kFirstWrong + config.flow.feedback_lag_frames;
    EXPECT_EQ(tracked.pose.trusted, !known) << sensors.frame_id << ' ' << tracked.pose.reason;
    EXPECT_EQ(tracked.pose.reason.find("do not show the same") != std::string::npos, known);
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
  for (const Pace pace : {Pace::kEveryFrame, Pace::kNewest}) {
    SensorFrame frame = test::TinySequence(1)[0];
    Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {}, pace);
    ThreadedPipeline threads(
        &pipeline, pace, [](const PoseEstimate&) {},
        [](const FrameResult&) { throw std::runtime_error("disk full"); });
    // Far more than all queues hold: a producer must be refused sooner or later, not left waiting.
    for (int i = 0; i < 100 && threads.Push(frame); ++i)
      frame.pair.t_capture = frame.pair.t_capture + std::chrono::seconds(1);
    EXPECT_THROW(threads.Finish(), std::runtime_error);
  }
}

TEST(ThreadedPipelineTest, AtTheNewestFramesPaceEveryFrameHasAPoseAndAResultOrIsCounted) {
  const SensorFrame first = test::TinySequence(1)[0];
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {}, Pace::kNewest);
  std::vector<FrameId> poses, results;
  Timestamp newest;
  ThreadedPipeline threads(
      &pipeline, Pace::kNewest, [&](const PoseEstimate& pose) { poses.push_back(pose.frame_id); },
      [&](const FrameResult& result) {
        results.push_back(result.pose.frame_id);
        newest = result.pose.t_capture;
      });
  const int num_pushed = 60;
  for (int i = 0; i < num_pushed; ++i) {
    SensorFrame frame = first;
    frame.pair.t_capture = frame.pair.t_capture + std::chrono::milliseconds(100 * i);
    if (i % 7 == 3)
      frame.pair = {.t_capture = frame.pair.t_capture, .left = {}, .right = {}, .problem = "is damaged"};
    EXPECT_TRUE(threads.Push(std::move(frame)));
  }
  threads.Finish();
  EXPECT_EQ(static_cast<std::int64_t>(poses.size()) + threads.counts().num_dropped, num_pushed);
  EXPECT_GT(threads.counts().num_dropped, 0) << "60 frames at once must be more than the odometry takes";
  EXPECT_EQ(results, poses);
  EXPECT_TRUE(std::is_sorted(poses.begin(), poses.end()));
  EXPECT_EQ(newest, first.pair.t_capture + std::chrono::milliseconds(100 * (num_pushed - 1)));
}

TEST(ThreadedPipelineTest, APoseLeavesWhileTheMapIsBusyWithAnEarlierFrame) {
  const std::vector<SensorFrame> frames = test::TinySequence(8);
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {}, Pace::kNewest);
  std::promise<void> all_poses;
  int num_poses = 0;
  const auto on_pose = [&](const PoseEstimate&) {
    if (++num_poses == static_cast<int>(frames.size())) all_poses.set_value();
  };
  std::shared_future<void> poses_are_out = all_poses.get_future().share();
  int num_results = 0;
  ThreadedPipeline threads(&pipeline, Pace::kNewest, on_pose, [&](const FrameResult&) {
    // The map of the first frame is not done before the poses of all frames are out.
    if (num_results++ > 0) return;
    EXPECT_EQ(poses_are_out.wait_for(std::chrono::seconds(30)), std::future_status::ready);
  });
  for (const SensorFrame& frame : frames) {
    // One after the other, so that the odometry drops none.
    while (threads.counts().num_waiting > 0) std::this_thread::yield();
    ASSERT_TRUE(threads.Push(frame));
  }
  threads.Finish();
  EXPECT_EQ(num_results + threads.counts().num_dropped, static_cast<int>(frames.size()));
}

TEST(SaveSamplesTest, PutsTheSamplesOfADroppedFrameInFrontOfTheNextOnes) {
  SensorFrame dropped, next;
  dropped.samples.imu.push_back({.t = Timestamp{1}});
  dropped.samples.priors.push_back({.t = Timestamp{2}});
  next.samples.imu.push_back({.t = Timestamp{3}});
  SaveSamples(dropped, &next);
  ASSERT_EQ(next.samples.imu.size(), 2U);
  EXPECT_EQ(next.samples.imu.front().t, Timestamp{1});
  ASSERT_EQ(next.samples.priors.size(), 1U);
}

TEST(PipelineTest, MapsNothingWhileOneCameraIsCoveredAndSaysSoOnce) {
  std::vector<SensorFrame> frames = test::TinySequence(8);
  for (std::size_t i = 3; i < 6; ++i)
    std::fill(frames[i].pair.right.data.begin(), frames[i].pair.right.data.end(), std::uint8_t{255});
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
  std::vector<std::size_t> num_warnings;
  std::vector<std::int64_t> seqs;
  for (const SensorFrame& frame : frames) {
    const FrameResult result = pipeline.Process(frame);
    num_warnings.push_back(result.warnings.size());
    seqs.push_back(result.change.map->seq);
  }
  EXPECT_EQ(seqs[5], seqs[2]) << "what a covered camera shows is in the map";
  EXPECT_GE(num_warnings[3], 1U);
  EXPECT_EQ(num_warnings[4] + num_warnings[5], 0U);
}

TEST(PipelineTest, APausedMapLetsThePosesGoOn) {
  const std::vector<SensorFrame> frames = test::TinySequence(2 * kFramesToBelieve);
  Pipeline pipeline(TinyConfig(), test::TinyCalibration(), {});
  std::int64_t map_cells = 0;
  for (int i = 0; i < 2 * kFramesToBelieve; ++i) {
    pipeline.PauseMap(i < kFramesToBelieve);
    const FrameResult result = pipeline.Process(frames[static_cast<std::size_t>(i)]);
    EXPECT_EQ(result.pose.status, TrackingStatus::kTracking);
    map_cells = result.change.map_cells;
    if (i < kFramesToBelieve) {
      EXPECT_EQ(map_cells, 0);
    }
  }
  EXPECT_GT(map_cells, 0);
}

}  // namespace
}  // namespace terrace
