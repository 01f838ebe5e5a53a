// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/place_view.h"
#include "odometry/image_pyramid.h"
#include "odometry/pose_solver.h"
#include "odometry/window.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// None near the border of the image.
std::optional<Descriptor> Describe(const ImagePyramid& image, const Eigen::Vector2d& pixel);
int Distance(const Descriptor& a, const Descriptor& b);

/// A feature of a frame and what it looks like.
struct DescribedFeature {
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();  ///< u, v, disparity [px]
  Descriptor descriptor{};
};
/// Those of the landmarks that do not lie near the border.
std::vector<DescribedFeature> DescribeAll(const ImagePyramid& left, const std::vector<Landmark>& landmarks);

/// Corners of a frame that has nothing to do with others, near enough for their distance to be known.
/// @param vertical_px  how much lower the right image is known to be
std::vector<DescribedFeature> DescribeFrame(const StereoFrame& frame, const StereoCamera& camera,
                                            double vertical_px);

/// Where the camera is among corners that another one saw at T_world_host; none: it does not see the same, or
/// too little of it to be sure.
std::optional<PoseSolution> Recognize(const std::vector<DescribedFeature>& features,
                                      const std::vector<PlaceCorner>& corners,
                                      const Eigen::Isometry3d& T_world_host, const StereoCamera& camera,
                                      std::uint32_t seed);

}  // namespace terrace
