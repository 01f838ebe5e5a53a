// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"

// Of poses: rotation [rad], then translation [m], in the frame of the pose. What Eigen's solvers make of 6x6
// costs a compiler seconds in every file that asks for it, so they are asked for here only.

namespace terrace {

/// What the covariance of T_a_b contributes to that of T_a_c = T_a_b * T_b_c.
Matrix6d TransportCovariance(const Eigen::Isometry3d& T_b_c, const Matrix6d& covariance);

/// Of a covariance the information, and the other way round.
Matrix6d Inverse(const Matrix6d& m);

/// error^T covariance^-1 error: 6 on average when the covariance is right.
double Chi2(const Vector6d& error, const Matrix6d& covariance);

/// x with H x = g; none unless H is positive.
std::optional<Vector6d> SolvePositive(const Matrix6d& H, const Vector6d& g);

}  // namespace terrace
