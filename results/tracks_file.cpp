// SPDX-License-Identifier: BSD-3-Clause
#include "results/tracks_file.h"

#include <cmath>
#include <utility>

#include "results/json_text.h"
#include "results/text_lines.h"

namespace terrace {
namespace {

OrderedJson SightingsJson(const FrameSightings& sightings, LandmarkFate fate) {
  OrderedJson list = OrderedJson::array();
  const auto tenths = [](float px) { return std::round(static_cast<double>(px) * 10.0) / 10.0; };
  for (const LandmarkSighting& sighting : sightings.landmarks)
    if (sighting.fate == fate)
      list.push_back({sighting.landmark, tenths(sighting.pixel.x()), tenths(sighting.pixel.y())});
  return list;
}

}  // namespace

std::string TracksLine(const ResultTracks& tracks) {
  OrderedJson line = {{"frame", tracks.frame},
                      {"t_capture_ns", tracks.t_capture.ns},
                      {"keyframe", tracks.sightings.is_keyframe}};
  for (const LandmarkFate fate : kLandmarkFates) line[Name(fate)] = SightingsJson(tracks.sightings, fate);
  return Dumped(line);
}

std::vector<ResultTracks> ReadTracksFile(const std::filesystem::path& path) {
  std::vector<ResultTracks> frames;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    ResultTracks tracks;
    tracks.frame = json["frame"].Integer();
    tracks.t_capture.ns = json["t_capture_ns"].Integer();
    tracks.sightings.is_keyframe = json["keyframe"].Bool();
    for (const LandmarkFate fate : kLandmarkFates) {
      for (const JsonValue& item : json[Name(fate)].Items()) {
        const std::vector<double> v = item.Numbers(3);  // ids are far below 2^53
        tracks.sightings.landmarks.push_back(
            {static_cast<std::int64_t>(v[0]), {static_cast<float>(v[1]), static_cast<float>(v[2])}, fate});
      }
    }
    if (!frames.empty() && tracks.frame <= frames.back().frame) json["frame"].Fail("must rise");
    frames.push_back(std::move(tracks));
  });
  return frames;
}

}  // namespace terrace
