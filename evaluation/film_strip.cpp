// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/film_strip.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "datasets/image_file.h"
#include "evaluation/disparity_picture.h"
#include "results/replay_result.h"

namespace terrace {
namespace {

/// The trails of one picture, from its line and the lines of the frames straight before it.
std::vector<FilmTrail> TrailsOf(const std::vector<ResultTracks>& lines, std::size_t picture) {
  std::size_t first = picture;
  while (first > 0 && lines[first - 1].frame + 1 == lines[first].frame) --first;
  std::map<std::int64_t, std::vector<FilmTrail::Point>> trails;
  for (std::size_t i = first; i < picture; ++i) {
    const FrameSightings& before = lines[i].sightings;
    for (const LandmarkSighting& sighting : before.landmarks)
      if (sighting.fate != LandmarkFate::kRejected)  // else it was something else
        trails[sighting.landmark].push_back({sighting.pixel, before.is_keyframe});
  }
  const FrameSightings& here = lines[picture].sightings;
  std::vector<FilmTrail> result;
  for (const LandmarkSighting& sighting : here.landmarks) {
    FilmTrail trail{sighting.fate, trails[sighting.landmark]};
    trail.points.push_back({sighting.pixel, here.is_keyframe});
    result.push_back(std::move(trail));
  }
  return result;
}

std::string Coordinates(const char* format, const Eigen::Vector2f& p) {
  char text[64];
  std::snprintf(text, sizeof(text), format, p.x(), p.y());
  return text;
}

}  // namespace

int FilmPicture::Count(LandmarkFate fate) const {
  return static_cast<int>(std::count_if(trails.begin(), trails.end(),
                                        [fate](const FilmTrail& trail) { return trail.fate == fate; }));
}

std::vector<FilmPicture> LoadFilm(const std::filesystem::path& result_folder) {
  const std::filesystem::path file = result_folder / "tracks.jsonl";
  const auto images = SavedTrackImages(result_folder);
  if (images.empty() || !std::filesystem::exists(file)) return {};
  const std::vector<ResultTracks> lines = ReadTracksFile(file);
  std::vector<FilmPicture> film;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto image = images.find(lines[i].t_capture);
    if (image == images.end()) continue;
    film.push_back({lines[i].frame, lines[i].t_capture, lines[i].sightings.is_keyframe,
                    ReadGrayImage(image->second), TrailsOf(lines, i)});
  }
  return film;
}

const char* ColourOf(LandmarkFate fate) {
  switch (fate) {
    case LandmarkFate::kAgrees:
      return "#3ddc84";
    case LandmarkFate::kRejected:
      return "#ff3b30";
    case LandmarkFate::kCreated:
      return "#ffd60a";
  }
  return "none";
}

std::string DrawPicture(const FilmPicture& picture) {
  const std::string width = std::to_string(picture.left.width), height = std::to_string(picture.left.height);
  std::string svg = "<svg viewBox=\"0 0 " + width + " " + height + "\">\n<image width=\"" + width +
                    "\" height=\"" + height + "\" href=\"" + JpegUri(picture.left) + "\"/>\n";
  // What was rejected last, so that nothing hides it.
  for (const LandmarkFate fate : {LandmarkFate::kAgrees, LandmarkFate::kCreated, LandmarkFate::kRejected}) {
    std::string lines, marks, keyframes;
    for (const FilmTrail& trail : picture.trails) {
      if (trail.fate != fate) continue;
      for (std::size_t i = 0; i < trail.points.size(); ++i) {
        const FilmTrail::Point& point = trail.points[i];
        lines += Coordinates(i == 0 ? "M%.1f %.1f" : "L%.1f %.1f", point.pixel);
        if (point.in_keyframe && i + 1 < trail.points.size())
          keyframes += Coordinates("M%.1f %.1fh0", point.pixel);
      }
      const Eigen::Vector2f& here = trail.points.back().pixel;
      if (fate == LandmarkFate::kAgrees) {
        marks += Coordinates("M%.1f %.1fm-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0 -5 0", here);
      } else if (fate == LandmarkFate::kCreated) {
        marks += Coordinates("M%.1f %.1fm-3.5 -3.5h7v7h-7z", here);
      } else {
        marks += Coordinates("M%.1f %.1fm-4 -4l8 8m0 -8l-8 8", here);
      }
    }
    if (marks.empty()) continue;
    svg += std::string("<g stroke=\"") + ColourOf(fate) +
           "\" fill=\"none\" stroke-linecap=\"round\"><path stroke-width=\"1.3\" d=\"" + lines +
           "\"/><path stroke-width=\"1.3\" d=\"" + marks + "\"/><path stroke-width=\"3.4\" d=\"" + keyframes +
           "\"/></g>\n";
  }
  if (picture.is_keyframe)
    svg += "<rect class=\"keyframe\" x=\"2\" y=\"2\" width=\"" + std::to_string(picture.left.width - 4) +
           "\" height=\"" + std::to_string(picture.left.height - 4) + "\"/>\n";
  return svg + "</svg>\n";
}

}  // namespace terrace
