// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "evaluation/disparity_file.h"
#include "evaluation/feet_evaluation.h"

namespace terrace {

/// Settings of the yardstick; its constants are those that users of such maps leave as they are.
struct ElevationMapConfig {
  double cell_m = 0.02;
  double disparity_sigma_px = 0.1;
  double max_range_m = 4.0;
  /// What is higher above the camera than this is overhead, not ground.
  double max_above_camera_m = 0.3;
  double gate_sigmas = 2.5;             ///< a height that is farther off is another surface
  double multi_height_noise_m = 0.003;  ///< what each such height adds to the cell's uncertainty
  double min_sigma_m = 0.003;
  double max_fit_residual_m = 0.015;  ///< steppable: the nine cells lie in a plane within this
  double max_slope_rad = 0.5236;      ///< steppable: not steeper than a ramp may be
};

/// The map that walking robots commonly plan on: one height and its variance in each cell of a level grid,
/// fused by a Kalman filter behind a gate (after Fankhauser, Bloesch and Hutter, "Probabilistic terrain
/// mapping for mobile robots with uncertain localization", 2018). A foothold is a cell whose 3x3
/// neighbourhood is known and lies in a plane. World z is up.
class ElevationMap : public Footholds {
 public:
  explicit ElevationMap(const ElevationMapConfig& config = {}) : config_(config) {}

  /// Fuses what one disparity image shows. Within it the highest surface of a cell wins.
  void Add(const FloatImage& disparity_px, const StereoCamera& camera, const Eigen::Isometry3d& T_world_left);

  /// Height of the cell that holds the point [m].
  std::optional<double> HeightAt(const Eigen::Vector2d& p) const;

  /// Finds the footholds of what was fused so far; before ForEach and OfferAt.
  void FindFootholds();

  void ForEach(const Use& use) const override;
  bool OfferAt(const Eigen::Vector3d& p, double height_m) const override;

 private:
  struct Cell {
    double height_m = 0.0;
    double variance_m2 = 0.0;
    int frame = 0;  ///< that measured it last
  };
  using CellIndex = std::pair<std::int32_t, std::int32_t>;

  CellIndex IndexOf(const Eigen::Vector2d& p) const;
  static std::int64_t Key(const CellIndex& index);
  const Cell* Find(const CellIndex& index) const;
  void Fuse(const CellIndex& index, double height_m, double variance_m2);
  /// The plane of the neighbourhood as height, slope along x, slope along y; none when it cannot be stepped
  /// on.
  std::optional<Eigen::Vector3d> FitPlane(const CellIndex& index) const;
  double HeightOn(const CellIndex& index, const Eigen::Vector3d& plane, const Eigen::Vector2d& p) const;

  ElevationMapConfig config_;
  int frame_ = 0;
  std::unordered_map<std::int64_t, Cell> cells_;
  std::map<CellIndex, Eigen::Vector3d> planes_;  ///< of the footholds
};

}  // namespace terrace
