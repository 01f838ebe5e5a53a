// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "core/time.h"
#include "mapping/point_moments.h"

namespace terrace {

constexpr int kNothing = -1;  ///< instead of an index

/// What is known of the surface in a leaf. There are millions of them: mean, covariance and direction are
/// whole numbers of two bytes, in steps that are far finer than the noise of the points. (Sums over the
/// points would grow, and need floats.) What a frame adds is rounded to a step, so that after `memory_frames`
/// frames a mean may lag by half as many steps: 0.01 mm in a leaf of 2 cm.
struct alignas(32) Leaf {
  float weight = 0.0F;                       ///< sum of 1 / variance over the points
  std::array<std::int16_t, 3> mean{};        ///< of the points, from the centre of the leaf
  std::array<std::int16_t, 6> covariance{};  ///< about the mean: xx xy xz yy yz zz
  std::array<std::int16_t, 3> view{};        ///< mean of the unit directions from the camera to the points
  std::uint16_t eighths_of_points = 0;       ///< old ones faded
  Eigen::half spacing_m{0.0F};               ///< finest one of the pixels across the view; 0: not known

  /// @param view_world  unit direction from the camera to the points
  /// @param edge_m      of the leaf
  void Add(const PointMoments& points, const Eigen::Vector3f& view_world, float edge_m);
  /// What was added before counts less from now on.
  void Fade(float factor);
  float num_points() const { return 0.125F * static_cast<float>(eighths_of_points); }
  Eigen::Vector3f Mean_m(float edge_m) const;
  Eigen::Matrix3f Covariance_m2(float edge_m) const;
  Eigen::Vector3f View() const;  ///< unit
};
static_assert(sizeof(Leaf) == 32);

/// Whether a leaf is occupied, and what says so. Apart from the surface, since every frame checks many leaves
/// that it adds nothing to.
struct Evidence {
  std::array<std::uint8_t, 3> corner{};  ///< lowest one, from that of the cell, in finest leaves
  std::uint8_t level : 5 = 0;
  std::uint8_t enough_points : 1 = 0;
  std::uint8_t occupied : 1 = 0;
  std::uint8_t alone : 1 = 0;  ///< without a coarser leaf above it; none comes while it is there
  int cell = kNothing;         ///< that holds the leaf; kNothing when the leaf is gone
  /// Frames that had the leaf in view, nothing in front of it, when its turn came to be checked; and those of
  /// them that put points into it.
  std::uint16_t num_views = 0;
  std::uint16_t num_hits = 0;
  std::uint16_t hit_frame = 0;  ///< the last one, as FrameBits
  /// Frames that hit it minus frames that saw through it; cleared below zero.
  std::int8_t credit = 0;
  std::uint8_t num_frames = 0;  ///< that put points into it, old ones faded

  /// The lowest bits of a frame's number: a leaf that was hit exactly 65,536 frames ago, and not since, is
  /// taken to be hit now, which is one hit too many.
  static std::uint16_t FrameBits(FrameId frame) { return static_cast<std::uint16_t>(frame); }
};
static_assert(sizeof(Evidence) == 16);

}  // namespace terrace
