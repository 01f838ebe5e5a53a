// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/frame_sink.h"
#include "daemon/progress.h"
#include "daemon/request_desk.h"
#include "daemon/result_writer.h"
#include "daemon/status_reporter.h"
#include "daemon/summary.h"
#include "daemon/terrain_publisher.h"
#include "daemon/track_writer.h"

namespace terrace {

/// The result files of DESIGN.md.
class ResultFiles : public FrameSink {
 public:
  ResultFiles(const std::filesystem::path& dir, const Pipeline& pipeline, int save_disparity_every)
      : writer_(dir, {pipeline.camera(), pipeline.R_rect_raw(), pipeline.T_body_left()},
                save_disparity_every) {}

  void AddFrame(const FrameResult& result) override { writer_.AddFrame(result, result.latency_ms); }
  void Finish(const RunTotals& totals) override {
    if (writer_.map()) writer_.Finish(totals);
  }
  const ResultWriter& writer() const { return writer_; }

 private:
  ResultWriter writer_;
};

/// Landmarks of some frames, drawn.
class TrackFiles : public FrameSink {
 public:
  TrackFiles(const std::filesystem::path& dir, int num_pictures, std::int64_t num_frames)
      : writer_(dir, num_pictures, num_frames) {}

  void AddFrame(const FrameResult& result) override { writer_.AddFrame(result); }
  void Finish(const RunTotals&) override { writer_.Finish(); }

 private:
  TrackWriter writer_;
};

/// Messages: the pose at once, the terrain when it is there.
class PublisherSink : public FrameSink {
 public:
  explicit PublisherSink(TerrainPublisher* publisher) : publisher_(publisher) {}

  void AddPose(const PoseEstimate& pose) override { publisher_->PublishPose(pose); }
  void AddFrame(const FrameResult& result) override { publisher_->PublishTerrain(result.change); }

 private:
  TerrainPublisher* const publisher_;
};

/// Answers to requests, after each frame.
class RequestSink : public FrameSink {
 public:
  /// @param publisher  of the map, a sink before this one
  RequestSink(RequestDesk* desk, const Pipeline* pipeline, const TerrainPublisher* publisher)
      : desk_(desk), pipeline_(pipeline), publisher_(publisher) {}

  void AddFrame(const FrameResult& result) override;

 private:
  RequestDesk* const desk_;
  const Pipeline* const pipeline_;
  const TerrainPublisher* const publisher_;
};

/// What the status tells of frames.
class StatusSink : public FrameSink {
 public:
  explicit StatusSink(StatusReporter* reporter) : reporter_(reporter) {}

  void AddPose(const PoseEstimate& pose) override { reporter_->AddPose(pose); }
  void AddFrame(const FrameResult& result) override { reporter_->AddResult(result); }

 private:
  StatusReporter* const reporter_;
};

/// Sentences for the user, in the log.
class WarningLog : public FrameSink {
 public:
  void AddFrame(const FrameResult& result) override;
};

/// What a person sees of a replay: how far it is, and a summary at its end.
class ReplayReport : public FrameSink {
 public:
  /// @param files  that are ended before this sink
  ReplayReport(const SequenceInfo& info, const ResultFiles* files, std::filesystem::path output)
      : files_(files),
        output_(std::move(output)),
        summary_(info),
        progress_(std::in_place, info.num_frames) {}

  void AddFrame(const FrameResult& result) override;
  void Finish(const RunTotals& totals) override;

 private:
  const ResultFiles* const files_;
  const std::filesystem::path output_;
  RunSummary summary_;
  std::optional<Progress> progress_;
};

}  // namespace terrace
