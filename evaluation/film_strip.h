// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/landmark_sightings.h"
#include "core/sensor_frame.h"
#include "core/time.h"

namespace terrace {

/// A landmark in a picture: where it was in the frames before, oldest first, and at last where it is.
struct FilmTrail {
  struct Point {
    Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
    bool in_keyframe = false;
  };
  LandmarkFate fate = LandmarkFate::kAgrees;
  std::vector<Point> points;
};

/// One picture of the film strip.
struct FilmPicture {
  std::int64_t frame = 0;  ///< from 0
  Timestamp t_capture;
  bool is_keyframe = false;
  GrayImage left;  ///< rectified
  std::vector<FilmTrail> trails;

  int Count(LandmarkFate fate) const;
};

/// The pictures that a replay with --save-tracks left in a folder, in order of time; none when it left none.
/// Throws FileError.
std::vector<FilmPicture> LoadFilm(const std::filesystem::path& result_folder);

/// A picture as an <svg> element that needs no other file.
std::string DrawPicture(const FilmPicture& picture);

/// As in CSS.
const char* ColourOf(LandmarkFate fate);

}  // namespace terrace
