// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/torn_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace terrace {
namespace {

/// Rows where the image may be torn: the edges of so many strips.
constexpr int kNumStrips = 12;
constexpr int kFewestOfPart = 10;  // landmarks of a part
/// Shares of a part's landmarks that are where they should be.
constexpr double kFew = 0.25, kMost = 0.5;
/// What moves less may be found from where it was.
constexpr double kMoved_px = 3.0;
constexpr double kThere_px = 1.5;

bool Seen(const Landmark& landmark, const Window& window, const StereoCamera& camera,
          const Eigen::Isometry3d& T_world_left, Eigen::Vector2d* pixel) {
  Projection projection;
  const Eigen::Isometry3d T_left_host = T_world_left.inverse() * window.at(landmark.host).T_world_left;
  if (!Project(landmark, T_left_host, camera, projection)) return false;
  *pixel = projection.uvd.head<2>();
  return true;
}

/// Whether a landmark is seen, and in another place than from where the camera was before.
/// @param before  its pixel there
bool HasMoved(const Landmark& landmark, const Window& window, const StereoCamera& camera,
              const Eigen::Isometry3d& T_world_left, const Eigen::Isometry3d& T_world_before,
              Eigen::Vector2d* now, Eigen::Vector2d* before) {
  return Seen(landmark, window, camera, T_world_left, now) &&
         Seen(landmark, window, camera, T_world_before, before) && (*now - *before).norm() >= kMoved_px;
}

}  // namespace

void TornImages::See(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
                     const PoseFinder::Found& found, const Eigen::Isometry3d& T_world_before) {
  const Part part = StrangePart(window, found, T_world_before);
  torn_ = lasting_.Update(
      part.end_row > part.first_row &&
      ShowsTheMomentBefore(part, window, left, right, found.solution.T_world_left, T_world_before));
}

TornImages::Part TornImages::StrangePart(const Window& window, const PoseFinder::Found& found,
                                         const Eigen::Isometry3d& T_world_before) const {
  std::vector<bool> agrees(window.landmarks.size(), false);
  for (std::size_t i = 0; i < found.matches.size(); ++i)
    if (found.solution.inlier[i]) agrees[static_cast<std::size_t>(found.matches[i].landmark)] = true;
  std::array<int, kNumStrips + 1> num{}, num_agreeing{};  // above the edge of each strip
  for (const int index : found.tried) {
    const Landmark& landmark = window.landmarks[static_cast<std::size_t>(index)];
    Eigen::Vector2d now, before;
    if (!HasMoved(landmark, window, camera_, found.solution.T_world_left, T_world_before, &now, &before))
      continue;
    const auto strip = std::clamp(static_cast<int>(kNumStrips * now.y() / camera_.height), 0, kNumStrips - 1);
    for (int edge = strip + 1; edge <= kNumStrips; ++edge) {
      ++num[static_cast<std::size_t>(edge)];
      num_agreeing[static_cast<std::size_t>(edge)] += agrees[static_cast<std::size_t>(index)];
    }
  }
  Part strange;
  double clearest = kMost - kFew;
  for (std::size_t edge = 1; edge < kNumStrips; ++edge) {
    const int above = num[edge], below = num.back() - num[edge];
    if (above < kFewestOfPart || below < kFewestOfPart) continue;
    const double share_above = static_cast<double>(num_agreeing[edge]) / above,
                 share_below = static_cast<double>(num_agreeing.back() - num_agreeing[edge]) / below;
    const bool apart =
        std::min(share_above, share_below) < kFew && std::max(share_above, share_below) > kMost;
    if (!apart || std::abs(share_above - share_below) <= clearest) continue;
    clearest = std::abs(share_above - share_below);
    const double row = static_cast<double>(edge) * camera_.height / kNumStrips;
    strange = share_above < share_below ? Part{0.0, row} : Part{row, static_cast<double>(camera_.height)};
  }
  return strange;
}

bool TornImages::ShowsTheMomentBefore(const Part& part, const Window& window, const ImagePyramid& left,
                                      const ImagePyramid& right, const Eigen::Isometry3d& T_world_left,
                                      const Eigen::Isometry3d& T_world_before) const {
  // What is far away is where it was in either moment.
  const auto has_moved = [&](int index) {
    Eigen::Vector2d now, before;
    return HasMoved(window.landmarks[static_cast<std::size_t>(index)], window, camera_, T_world_left,
                    T_world_before, &now, &before) &&
           part.Holds(before.y());
  };
  const Matches matches = tracker_.Track(window, left, right, T_world_before, 0.0, {1, 0, 2, false});
  const auto num_tried = std::count_if(matches.tried.begin(), matches.tried.end(), has_moved);
  const auto num_there = std::count_if(matches.found.begin(), matches.found.end(), [&](const Match& match) {
    const Eigen::Vector2d off = match.measurement.uvd.head<2>() - match.predicted.uvd.head<2>();
    return off.norm() < kThere_px && has_moved(match.landmark);
  });
  return num_there >= kFewestOfPart &&
         static_cast<double>(num_there) > kMost * static_cast<double>(num_tried);
}

}  // namespace terrace
