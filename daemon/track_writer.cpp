// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/track_writer.h"

#include "daemon/result_writer.h"
#include "datasets/image_file.h"
#include "results/tracks_file.h"

namespace terrace {
namespace {

/// Frames before a picture whose landmarks are its trails.
constexpr std::int64_t kTrailFrames = 11;

GrayImage ImageOf(const cv::Mat1b& mat) {
  GrayImage image{mat.cols, mat.rows, {}};
  for (int row = 0; row < mat.rows; ++row) image.data.insert(image.data.end(), mat[row], mat[row] + mat.cols);
  return image;
}

}  // namespace

TrackWriter::TrackWriter(const std::filesystem::path& dir, int num_pictures, std::int64_t num_frames)
    : dir_(dir), file_(dir / "tracks.jsonl", std::ios::binary | std::ios::trunc) {
  // The middles of so many equal parts of the run.
  for (int k = 0; k < num_pictures; ++k) {
    const std::int64_t frame = (2 * k + 1) * num_frames / (2 * num_pictures);
    if (due_.empty() || due_.back() < frame) due_.push_back(frame);
  }
  std::filesystem::create_directories(dir / "tracks");
}

void TrackWriter::AddFrame(const FrameResult& result) {
  const std::int64_t frame = num_frames_++;
  if (due_.empty() || frame + kTrailFrames < due_.front()) return;
  WriteLine(result);
  // A frame that could not be read is shown by the next one.
  if (frame < due_.front() || !result.frame) return;
  WritePng(dir_ / "tracks" / (std::to_string(result.pose.t_capture.ns) + ".png"),
           ImageOf(result.frame->left));
  while (!due_.empty() && due_.front() <= frame) due_.pop_front();
}

void TrackWriter::WriteLine(const FrameResult& result) {
  const ResultTracks line{num_frames_ - 1, result.pose.t_capture, result.sightings};
  file_ << TracksLine(line) << '\n';
}

void TrackWriter::Finish() {
  file_.flush();
  if (!file_)
    throw OutputError(dir_.string() + ": tracks.jsonl could not be written whole: is the disk full?");
}

}  // namespace terrace
