// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "mapping/terrain_octree.h"

namespace terrace {

/// A surface is not seen from behind, and hardly edge on: cosine between the normal and the way to the
/// camera.
constexpr float kLeastFacing = 0.03F;

/// A plane relative to the centre of the cell.
struct CellPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float offset_m = 0.0F;
  /// The share of what the noise of its leaves allows within which they lie.
  float scale = 1.0F;
};

/// How far from a plane a leaf may lie that belongs to it.
struct InlierLimits {
  float least_m;      ///< however little noise it has
  float most_m;       ///< however much
  float cell_size_m;  ///< as loose as a plane can be
};

/// Three standard deviations of a leaf's points along the normal, within the limits.
/// @param facing  cosine between the normal and the way to the camera
inline float Allowed_m(const Surfel& s, float facing, const InlierLimits& limits) {
  const float noise_m = 3.0F * s.sigma_view_m * facing;
  return noise_m < limits.least_m ? limits.least_m : (noise_m > limits.most_m ? limits.most_m : noise_m);
}

/// What decides whether leaves speak for a plane, in columns, so that many are asked at once.
class SurfelColumns {
 public:
  /// Partial sums are kept by leaf number modulo this, so that every instruction set adds alike.
  static constexpr std::size_t kLanes = 16;
  enum Column { kX, kY, kZ, kViewX, kViewY, kViewZ, kThreeSigmas, kArea, kNumColumns };

  /// Takes the leaves of these numbers; the last ones of kLanes, which are none, have no area.
  void Assign(const std::vector<Surfel>& surfels, const std::vector<int>& indices);

  std::size_t size() const { return size_; }  ///< a multiple of kLanes
  const float* column(Column c) const { return values_.data() + static_cast<std::size_t>(c) * size_; }

 private:
  std::size_t size_ = 0;
  std::vector<float> values_;
};

/// How much better a plane explains the leaves than nothing does, by area: a share of what their distances
/// leave of what is allowed, and a share for how tight it is, as the logarithm of the likelihood has it
/// (MLESAC, Torr and Zisserman 2000; half of it here, since leaves are no points and their noise is a
/// guess). So a plane across the steps of a flight far away, which is loose because it is seen from the
/// front, does not pass for the treads, which are tight because they are seen flat. How tight it is shows
/// in the leaves, too: their noise is a guess, so the plane takes that share of it which explains them best
/// (`plane->scale`).
float Explained(const SurfelColumns& leaves, const InlierLimits& limits, CellPlane* plane);

}  // namespace terrace
