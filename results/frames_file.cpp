// SPDX-License-Identifier: BSD-3-Clause
#include "results/frames_file.h"

#include <utility>

#include "results/json_text.h"
#include "results/text_lines.h"

namespace terrace {
namespace {

TrackingStatus ReadStatus(const JsonValue& json) {
  const std::string text = json.Text();
  for (TrackingStatus status :
       {TrackingStatus::kTracking, TrackingStatus::kBridging, TrackingStatus::kLost}) {
    if (text == Name(status)) return status;
  }
  json.Fail("must be tracking, bridging or lost");
}

}  // namespace

std::string FrameLine(const ResultFrame& frame) {
  const OrderedJson line = {
      {"t_capture_ns", frame.t_capture.ns},
      {"status", Name(frame.status)},
      {"reason", frame.reason},
      {"covariance", frame.covariance ? RowMajorJson(*frame.covariance) : OrderedJson(nullptr)},
      {"latency_ms", OrNullJson(frame.latency_ms)},
      {"map_cells", frame.map_cells},
      {"regions", frame.regions},
      {"epoch", frame.epoch}};
  return Dumped(line);
}

std::vector<ResultFrame> ReadFramesFile(const std::filesystem::path& path) {
  std::vector<ResultFrame> frames;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    ResultFrame frame;
    frame.t_capture.ns = json["t_capture_ns"].Integer();
    frame.status = ReadStatus(json["status"]);
    frame.reason = json["reason"].Text();
    if (!json["covariance"].IsNull()) {
      const std::vector<double> rows = json["covariance"].Numbers(36);
      frame.covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows.data());
    }
    if (!json["latency_ms"].IsNull()) frame.latency_ms = json["latency_ms"].Number();
    frame.map_cells = json["map_cells"].Integer();
    frame.regions = json["regions"].Integer();
    if (json.Has("epoch")) frame.epoch = static_cast<int>(json["epoch"].Integer());
    frames.push_back(std::move(frame));
  });
  return frames;
}

}  // namespace terrace
