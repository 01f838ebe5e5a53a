// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/ground_truth.h"
#include "datasets/synthetic/renderer.h"

namespace terrace::synthetic {

/// What was seen of one polygon.
struct SeenSurface {
  std::int64_t pixels = 0;
  std::int64_t frames = 0;
  double nearest_depth_m = 0.0;  ///< 0: never seen
  ObservedCells cells;
  double observed_fraction = 0.0;  ///< of the cells whose centre lies on the polygon; -1: it has none
  double observed_area_m2 = 0.0;
};

/// Keeps account of what the left camera sees of every polygon while it moves.
class SeenSurfaces {
 public:
  explicit SeenSurfaces(const Scene& scene);

  /// Rows from first_row on, every row_step-th, of one view; each pixel stands for row_step of them.
  void Add(const TrueView& view, const Eigen::Isometry3d& T_world_left, int first_row, int row_step);
  /// With fractions; cells whose centre lies beyond the rings do not count as seen.
  std::vector<SeenSurface> Finish() const;

 private:
  const Scene& scene_;
  std::vector<SeenSurface> seen_;
};

/// What else goes into ground_truth.json.
struct SequenceFacts {
  int num_frames = 0;
  double rate_hz = 0.0;
  double path_length_m = 0.0;
  std::string motion;
  std::uint32_t seed = 1;
};

/// Writes ground_truth.json and observed_cells.npz. Throws FileError.
void WriteTruth(const Scene& scene, const std::vector<SeenSurface>& seen, const SequenceFacts& facts,
                const std::filesystem::path& folder);

}  // namespace terrace::synthetic
