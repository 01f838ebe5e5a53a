// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "results/replay_result.h"

namespace terrace {

/// Cells of true polygons by polygon id, on the grid of their observed cells.
using CellsOfPolygons = std::map<int, ObservedCells>;

/// Which cells of the true walkways, ramps and treads (details left out) a mapper could see well: at least 4
/// pixels in the cell, within 2.5 m of the camera, in at least two of the frames.
class WellSeenCells {
 public:
  /// @param scene  kept by reference
  explicit WellSeenCells(const TrueScene& scene);

  /// @param labels  polygon ids as the left camera saw them
  void Add(const Gray16Image& labels, const StereoCamera& camera, const Eigen::Isometry3d& T_world_left);

  CellsOfPolygons Cells() const;

 private:
  struct Counts {
    const TruePolygon* polygon;
    std::vector<std::uint16_t> pixels;  ///< of the frame in hand, by cell
    std::vector<std::uint16_t> frames;  ///< that saw the cell well
  };

  std::map<int, Counts> counts_;
};

/// False when rectification turned the camera, so that true depth and label images are of another one.
bool TrueImagesApply(const ResultCamera& camera);

/// From the label images of a sequence that have a true pose of the same moment; none when there are no label
/// images, or they do not apply. Throws FileError.
std::optional<CellsOfPolygons> LoadWellSeenCells(const std::filesystem::path& sequence,
                                                 const TrueScene& scene, const ResultCamera& camera,
                                                 const std::vector<TimedPose>& true_left);

}  // namespace terrace
