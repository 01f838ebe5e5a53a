// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/leaf.h"

#include <algorithm>

#include "core/rounding.h"

namespace terrace {
namespace {

constexpr float kSteps = 32767.0F;  // from zero to the greatest number
/// Points lie within half an edge of the centre, so that no covariance is above a quarter of its square.
constexpr float kMeanSteps = 2.0F * kSteps;        // along the edge of a leaf
constexpr float kCovarianceSteps = 4.0F * kSteps;  // along its square

std::int16_t InSteps(float value) {
  return static_cast<std::int16_t>(FloorToInt(std::clamp(value, -kSteps, kSteps) + 0.5F));
}

Eigen::Vector3f Vector(const std::array<std::int16_t, 3>& v) { return Eigen::Vector3f(v[0], v[1], v[2]); }

void MoveTowards(const Eigen::Vector3f& goal, float share, std::array<std::int16_t, 3>* v) {
  for (std::size_t i = 0; i < 3; ++i) {
    const float before = (*v)[i];
    (*v)[i] = InSteps(before + share * (goal[static_cast<Eigen::Index>(i)] - before));
  }
}

/// Of the entries xx xy xz yy yz zz.
constexpr std::array<std::array<int, 2>, 6> kEntries{{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

}  // namespace

/// Mean and covariance of two sets of points together follow from those of each (Chan, Golub and LeVeque,
/// "Updating formulae and a pairwise algorithm for computing sample variances", 1979).
void Leaf::Add(const PointMoments& points, const Eigen::Vector3f& view_world, float edge_m) {
  const float eighths = static_cast<float>(eighths_of_points) + 8.0F * points.num_points;
  weight += points.weight;
  const float share = points.weight / weight;
  const float per_weight = 1.0F / points.weight;
  const Eigen::Vector3f their_mean_m =
      per_weight * Eigen::Vector3f(points.sum[0], points.sum[1], points.sum[2]);
  const Eigen::Vector3f apart_m = their_mean_m - Mean_m(edge_m);
  const float steps = kCovarianceSteps / (edge_m * edge_m);
  for (std::size_t i = 0; i < kEntries.size(); ++i) {
    const auto [row, column] = kEntries[i];
    const float theirs = per_weight * points.sum_outer[i] - their_mean_m[row] * their_mean_m[column];
    const float goal = steps * (theirs + (1.0F - share) * apart_m[row] * apart_m[column]);
    const float before = covariance[i];
    covariance[i] = InSteps(before + share * (goal - before));
  }
  MoveTowards(kMeanSteps / edge_m * their_mean_m, share, &mean);
  MoveTowards(kSteps * view_world, share, &view);
  // Nobody asks beyond so many points, but for their mean variance.
  constexpr float kMost = 65535.0F;
  eighths_of_points = static_cast<std::uint16_t>(std::min(eighths, kMost));
  if (eighths > kMost) weight *= kMost / eighths;
}

void Leaf::Fade(float factor) {
  weight *= factor;
  eighths_of_points =
      static_cast<std::uint16_t>(FloorToInt(factor * static_cast<float>(eighths_of_points) + 0.5F));
}

Eigen::Vector3f Leaf::Mean_m(float edge_m) const { return edge_m / kMeanSteps * Vector(mean); }

Eigen::Matrix3f Leaf::Covariance_m2(float edge_m) const {
  const float step_m2 = edge_m * edge_m / kCovarianceSteps;
  Eigen::Matrix3f matrix;
  for (std::size_t i = 0; i < kEntries.size(); ++i) {
    const auto [row, column] = kEntries[i];
    matrix(row, column) = matrix(column, row) = step_m2 * covariance[i];
  }
  return matrix;
}

Eigen::Vector3f Leaf::View() const { return Vector(view).normalized(); }

}  // namespace terrace
