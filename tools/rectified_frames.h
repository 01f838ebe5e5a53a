// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "lcmtypes/channels.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Calls `use` for every frame of a sequence that is `wanted`, in order, rectified as the replay that left
/// `camera` did; ends early when `use` gives false. Throws SequenceError, and std::runtime_error when a
/// wanted frame cannot be read.
/// @param channels  of the sequence, where that is a log
/// @param calibration  the files that the replay was given; empty: the sequence's own
void ForRectifiedFrames(const std::filesystem::path& sequence, const ChannelConfig& channels,
                        const std::vector<std::filesystem::path>& calibration, const StereoCamera& camera,
                        const std::function<bool(const SensorFrame&)>& wanted,
                        const std::function<bool(const StereoFrame&)>& use);

}  // namespace terrace
