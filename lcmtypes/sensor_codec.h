// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <terrace/body_prior_v1_t.hpp>
#include <terrace/imu_v1_t.hpp>
#include <terrace/pose_t.hpp>

#include "core/sensor_frame.h"

namespace terrace {

imu_v1_t ToMessage(const ImuSample& sample);
std::optional<ImuSample> FromMessage(const imu_v1_t& message);

/// The rotation travels as CanonicalQuaternion.
body_prior_v1_t ToMessage(const BodyPrior& prior);
std::optional<BodyPrior> FromMessage(const body_prior_v1_t& message);
/// A prior from a robot that publishes poses without covariance.
std::optional<BodyPrior> PriorFromPose(const pose_t& message, PriorKind kind);

}  // namespace terrace
