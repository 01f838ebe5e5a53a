// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "labeling/label_rules.h"
#include "labeling/region_shape.h"
#include "labeling/shape_table.h"

namespace terrace {

/// Remembers from where every shape was seen: how near, and whether the tops of faces were in view.
class ViewMemory {
 public:
  /// @param camera      width 0: not known, no top is ever judged
  /// @param max_depth_m  farther away nothing is judged
  ViewMemory(const StereoCamera& camera, double max_depth_m) : camera_(camera), max_depth_m_(max_depth_m) {}

  /// Looks from where the camera is now at the shapes that are to be looked at; forgets those that are gone.
  void Look(const ShapeTable& table, const Eigen::Isometry3d& T_level_left, Timestamp t_now);

  /// In the order of the shapes last looked at.
  const std::vector<TopView>& tops() const { return tops_; }
  const std::vector<double>& nearest_view_m() const { return nearest_view_m_; }

 private:
  struct Memory {
    double nearest_m = 0.0;
    double top_m = 0.0;  ///< height up to which the counts hold
    int num_seen = 0;    ///< frames in which what lies above the top was in view
    int num_cut = 0;     ///< frames in which the view ended there
  };
  void JudgeTop(const RegionShape& face, const Eigen::Isometry3d& T_left_level, Memory& memory) const;

  StereoCamera camera_;
  double max_depth_m_ = 0.0;
  std::map<PolygonId, Memory> memories_;
  std::vector<TopView> tops_;
  std::vector<double> nearest_view_m_;
};

}  // namespace terrace
