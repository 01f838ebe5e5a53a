// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "datasets/ground_truth.h"
#include "evaluation/map_shapes.h"
#include "evaluation/planar_shape.h"

namespace terrace {

/// A point of a true edge of ground beyond which there is nothing to stand on, or only lower ground.
struct DropSample {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d outwards = Eigen::Vector3d::Zero();  ///< unit, horizontal
};

/// The true surfaces as feet meet them: from above. World z is up.
class TrueGround {
 public:
  explicit TrueGround(const TrueScene& scene);

  /// Does a true surface of any label, not upright, lie within `height_m` above or below the point, somewhere
  /// in the level disc of radius `disc_m` about it? The surface's plane is asked at the middle of the disc.
  bool Carries(const Eigen::Vector3d& p, double disc_m, double height_m) const;

  /// Every 2 cm along the edges of walkways, ramps and treads that are no detail: where 3 cm beyond the edge
  /// the highest surface not more than 2.5 cm above it is at least 5 cm below, or absent, and no upright face
  /// rises at the edge.
  std::vector<DropSample> Drops() const;

 private:
  /// A surface that is not upright, seen from above.
  struct Support {
    Plane plane;
    PlanarShape plan;  ///< in the plane z = 0
    double HeightAt(const Eigen::Vector3d& p) const;
  };

  /// Of the highest surface right above or below the point that is not more than 2.5 cm above it.
  std::optional<double> HighestBelow(const Eigen::Vector3d& p) const;
  bool FaceRisesAt(const Eigen::Vector3d& p) const;

  std::vector<TrueShape> shapes_;
  std::vector<Support> supports_;
};

}  // namespace terrace
