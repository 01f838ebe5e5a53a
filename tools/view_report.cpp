// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_report.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/file_bytes.h"
#include "core/print.h"
#include "tools/commands.h"
#include "tools/rectified_frames.h"
#include "tools/terrain_picture.h"
#include "tools/view_page.h"

namespace terrace {
namespace {

struct ReportOptions {
  std::filesystem::path result;
  std::filesystem::path out;
  ReportSource source;
  std::string page;
};

// Of the images that the page can play, these many are also shown as pictures with the regions drawn over.
constexpr std::size_t kNumPictures = 4;

/// Evenly over the way, the last pose always.
std::map<Timestamp, const ResultPose*> ChosenPoses(const std::vector<ResultPose>& trajectory,
                                                   std::size_t count) {
  std::map<Timestamp, const ResultPose*> chosen;
  const std::size_t n = std::min(count, trajectory.size());
  for (std::size_t i = 1; i <= n; ++i) {
    const ResultPose& pose = trajectory[i * trajectory.size() / n - 1];
    chosen[pose.t_capture] = &pose;
  }
  return chosen;
}

std::string Jpeg(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw std::runtime_error("an image cannot be written as JPEG");
  }
  return {bytes.begin(), bytes.end()};
}

struct ReportImages {
  std::vector<ViewBytes> records;
  std::vector<ViewPicture> pictures;
};

ReportImages CollectImages(const ReplayResult& result, const ReportSource& source) {
  constexpr int kPlainQuality = 70, kPictureQuality = 85;
  const auto num_images = static_cast<std::size_t>(source.num_images);
  const auto poses = ChosenPoses(result.trajectory, num_images);
  const auto drawn = ChosenPoses(result.trajectory, std::min(kNumPictures, num_images));
  std::set<Timestamp> missing;
  for (const auto& [t, pose] : poses) missing.insert(t);
  for (const auto& [t, pose] : drawn) missing.insert(t);
  const Timestamp t_first = result.frames.empty() ? Timestamp{} : result.frames.front().t_capture;
  ReportImages images;
  ForRectifiedFrames(
      source.sequence, {}, source.calibration, result.camera.camera,
      [&](const SensorFrame& frame) { return missing.contains(frame.pair.t_capture); },
      [&](const StereoFrame& frame) {
        const Timestamp t = frame.t_capture;
        if (poses.contains(t)) {
          const std::string jpeg = Jpeg(frame.left, kPlainQuality);
          images.records.push_back(MakeViewRecord(ViewRecordKind::kImage, t, jpeg));
        }
        if (const auto found = drawn.find(t); found != drawn.end()) {
          const cv::Mat3b picture =
              DrawFrame(result.map, frame.left, result.camera.camera, found->second->T_world_left);
          images.pictures.push_back(
              {Printed("after %.1f s", Seconds(t - t_first)), t, Jpeg(picture, kPictureQuality)});
        }
        missing.erase(t);
        return !missing.empty();
      });
  if (!missing.empty()) throw std::runtime_error(source.sequence + ": is not the sequence of this result");
  return images;
}

void Report(const ReportOptions& options) {
  const std::string page = ReadViewPage(options.page);
  const ReplayResult result = ReadReplayResult(options.result);
  const std::filesystem::path out = options.out.empty() ? options.result / "view.html" : options.out;
  const std::string whole = ReportPage(page, result, options.source);
  WriteFileBytes(out, std::span(reinterpret_cast<const std::uint8_t*>(whole.data()), whole.size()));
  std::printf("look around  %s (%.1f MB, opens in any browser)\n", out.c_str(),
              1e-6 * static_cast<double>(whole.size()));
}

}  // namespace

std::string ReportPage(const std::string& page, const ReplayResult& result, const ReportSource& source,
                       ViewBeside beside, const std::vector<ViewBytes>& more) {
  ReportImages images = source.num_images > 0 ? CollectImages(result, source) : ReportImages{};
  beside.pictures = std::move(images.pictures);
  std::vector<ViewBytes> records = RecordsOfResult(result, "report", beside);
  records.insert(records.end(), more.begin(), more.end());
  records.insert(records.end(), images.records.begin(), images.records.end());
  return PageWithRecording(page, records);
}

void AddReportCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "report", "Write a replay's map, path, figures and images as one page to look around in");
  auto options = std::make_shared<ReportOptions>();
  command->add_option("RESULT_DIR", options->result, "what terraced replay wrote")->required();
  command->add_option("SEQUENCE", options->source.sequence, "what it replayed")->required();
  command->add_option("OUT.html", options->out, "default: view.html in RESULT_DIR");
  command->add_option("--images", options->source.num_images, "camera images in the page")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      ->add_option("--calibration", options->source.calibration,
                   "the files that the replay was given, if it was")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--page", options->page, "the page to use instead of the installed one");
  command->callback([options] { Report(*options); });
}

}  // namespace terrace
