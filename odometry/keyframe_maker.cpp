// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/keyframe_maker.h"

#include <algorithm>
#include <utility>

namespace terrace {

std::vector<Landmark> KeyframeMaker::Look(const ImagePyramid& left, const ImagePyramid& right,
                                          double vertical_px) const {
  const std::vector<bool> nothing(static_cast<std::size_t>(grid_.num_cells()), false);
  return finder_.Find(left, right, nothing, vertical_px);
}

KeyframeMaker::Made KeyframeMaker::Make(Keyframe keyframe, const ImagePyramid& left,
                                        const ImagePyramid& right, double vertical_px,
                                        const PoseFinder::Found& found, Window& window,
                                        FrameSightings& sightings) {
  keyframe.id = next_keyframe_id_++;
  keyframe.left = left;
  constexpr double kRest_m = 0.005;
  Made made;
  made.rests =
      !window.keyframes.empty() &&
      (keyframe.T_world_left.translation() - window.keyframes.back().T_world_left.translation()).norm() <
          kRest_m;

  // Cells where a landmark is seen much as in its host need no new one.
  constexpr double kSameScale = 1.4;
  std::vector<bool> occupied(static_cast<std::size_t>(grid_.num_cells()), false);
  for (std::size_t i = 0; i < found.matches.size(); ++i) {
    if (!found.solution.inlier[i]) continue;
    const Match& match = found.matches[i];
    const StereoMeasurement& m = match.measurement;
    window.landmarks[static_cast<std::size_t>(match.landmark)].observations.push_back({keyframe.id, m});
    if (match.scale < kSameScale && match.scale > 1.0 / kSameScale)
      occupied[static_cast<std::size_t>(grid_.CellOf(m.uvd.x(), m.uvd.y()))] = true;
  }
  const KeyframeId id = keyframe.id;
  window.keyframes.push_back(std::move(keyframe));
  sightings.is_keyframe = true;
  for (Landmark& landmark : finder_.Find(left, right, occupied, vertical_px)) {
    landmark.id = next_landmark_id_++;
    landmark.host = id;
    sightings.landmarks.push_back({landmark.id, landmark.pixel_host.cast<float>(), LandmarkFate::kCreated});
    window.landmarks.push_back(std::move(landmark));
  }
  constexpr int kMaxFailures = 3;
  std::erase_if(window.landmarks,
                [](const Landmark& landmark) { return landmark.num_failures >= kMaxFailures; });

  std::vector<bool> covered = occupied;
  for (const Landmark& landmark : window.landmarks)
    if (landmark.host == id)
      covered[static_cast<std::size_t>(grid_.CellOf(landmark.pixel_host.x(), landmark.pixel_host.y()))] =
          true;
  made.covered_cells =
      std::max<double>(1.0, static_cast<double>(std::count(covered.begin(), covered.end(), true)));
  return made;
}

void CountFates(const PoseFinder::Found& found, Window& window) {
  for (const int i : found.tried) {
    Landmark& landmark = window.landmarks[static_cast<std::size_t>(i)];
    ++landmark.num_missed;
    landmark.missed_last = true;
  }
  for (std::size_t i = 0; i < found.matches.size(); ++i) {
    Landmark& landmark = window.landmarks[static_cast<std::size_t>(found.matches[i].landmark)];
    const bool agrees = found.solution.inlier[i];
    landmark.num_failures = agrees ? 0 : landmark.num_failures + 1;
    landmark.num_tracked += agrees;
    landmark.num_missed -= agrees;
    landmark.missed_last = !agrees;
  }
}

void NoteSightings(const PoseFinder::Found& found, const Window& window, FrameSightings& sightings) {
  for (std::size_t i = 0; i < found.matches.size(); ++i)
    sightings.landmarks.push_back(
        {window.landmarks[static_cast<std::size_t>(found.matches[i].landmark)].id,
         found.matches[i].measurement.uvd.head<2>().cast<float>(),
         found.solution.inlier[i] ? LandmarkFate::kAgrees : LandmarkFate::kRejected});
}

}  // namespace terrace
