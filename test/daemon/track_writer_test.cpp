// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/track_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "evaluation/film_strip.h"
#include "results/replay_result.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

class TrackWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::path(testing::TempDir()) /
           ("terrace_tracks_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(dir_);
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  /// Landmark 5 is one pixel farther right and 0.26 farther down in every frame; 6 is rejected in every one.
  static FrameResult Frame(std::int64_t frame) {
    FrameResult result;
    result.pose.t_capture = Timestamp{1000 + frame};
    auto stereo = std::make_shared<StereoFrame>();
    stereo->left = cv::Mat1b(6, 8, static_cast<std::uint8_t>(frame));
    result.frame = stereo;
    const auto f = static_cast<float>(frame);
    result.sightings.landmarks = {{5, {f, 0.26F * f}, LandmarkFate::kAgrees},
                                  {6, {3.0F, 4.0F}, LandmarkFate::kRejected}};
    return result;
  }

  std::vector<std::int64_t> Pictures() const {
    std::vector<std::int64_t> frames;
    for (const FilmPicture& picture : LoadFilm(dir_)) frames.push_back(picture.frame);
    return frames;
  }

  fs::path dir_;
};

TEST_F(TrackWriterTest, KeepsPicturesSpreadOverTheRunAndTheTrailsThatLeadToThem) {
  TrackWriter writer(dir_, 4, 200);
  for (int i = 0; i < 200; ++i) {
    FrameResult result = Frame(i);
    result.sightings.is_keyframe = i % 5 == 0;
    if (i == 75) result.sightings.landmarks.push_back({7, {1.5F, 2.5F}, LandmarkFate::kCreated});
    writer.AddFrame(result);
  }
  writer.Finish();
  EXPECT_EQ(ReadTracksFile(dir_ / "tracks.jsonl").size(), 4u * 12u);  // bounded, however long the run
  const std::vector<FilmPicture> film = LoadFilm(dir_);
  EXPECT_THAT(Pictures(), ElementsAre(25, 75, 125, 175));
  const FilmPicture& picture = film[1];
  EXPECT_EQ(picture.t_capture.ns, 1075);
  EXPECT_TRUE(picture.is_keyframe);
  EXPECT_EQ(picture.left.width, 8);
  EXPECT_EQ(picture.left.data, std::vector<std::uint8_t>(48, 75));
  ASSERT_EQ(picture.trails.size(), 3u);
  const FilmTrail& agreeing = picture.trails[0];
  EXPECT_EQ(agreeing.fate, LandmarkFate::kAgrees);
  ASSERT_EQ(agreeing.points.size(), 12u);  // of this stretch only, not of the one fifty frames earlier
  EXPECT_FLOAT_EQ(agreeing.points.front().pixel.x(), 64.0F);
  EXPECT_FLOAT_EQ(agreeing.points.back().pixel.x(), 75.0F);
  EXPECT_FLOAT_EQ(agreeing.points.back().pixel.y(), 19.5F);
  EXPECT_TRUE(agreeing.points[6].in_keyframe);
  EXPECT_FALSE(agreeing.points[7].in_keyframe);
  // Where it was rejected is no trail.
  EXPECT_EQ(picture.trails[1].fate, LandmarkFate::kRejected);
  EXPECT_EQ(picture.trails[1].points.size(), 1u);
  EXPECT_EQ(picture.Count(LandmarkFate::kCreated), 1);
}

TEST_F(TrackWriterTest, ShowsTheNextFrameWhereOneCannotBeRead) {
  TrackWriter writer(dir_, 2, 40);
  for (int i = 0; i < 40; ++i) {
    FrameResult result = Frame(i);
    if (i == 10 || i == 11) result.frame = nullptr;
    writer.AddFrame(result);
  }
  writer.Finish();
  EXPECT_THAT(Pictures(), ElementsAre(12, 30));
}

TEST_F(TrackWriterTest, ShowsEveryFrameOfARunThatHasFewer) {
  TrackWriter writer(dir_, 8, 3);
  for (int i = 0; i < 3; ++i) writer.AddFrame(Frame(i));
  writer.Finish();
  EXPECT_THAT(Pictures(), ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace terrace
