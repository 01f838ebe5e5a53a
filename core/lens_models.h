// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"

namespace terrace {

/// The equations of the lens models: where a ray (of any length) lands on the image plane, in units of the
/// focal length, so that the pixel is (fx m_x + cx, fy m_y + cy). Not a number where the model has no answer.
/// It says nothing about rays beyond the angle where a model turns back: `Lens` does.
Eigen::Vector2d ProjectByModel(const RawCamera& camera, const Eigen::Vector3d& ray);

/// The model without what is not symmetric about the axis.
RawCamera WithoutAsymmetry(RawCamera camera);

/// Counts of coefficients that a model takes, ascending.
std::vector<std::size_t> CoefficientCounts(DistortionModel model);

}  // namespace terrace
