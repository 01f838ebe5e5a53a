// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/sensor_frame.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// The ways in which a sequence can be made worse, by name: the robustness set. Beside them there is `blink`,
/// gaps of one to ten black frames all along: for the covariance while bridging.
const std::vector<std::string>& DamageNames();

/// Damages a sequence in memory. Pixels are copied before they are touched; samples of frames that are
/// dropped go to the next one. Same input, same damage.
void ApplyDamage(const std::string& name, std::vector<StereoFrame>& frames,
                 std::vector<SensorSamples>& samples);

/// At most one grey value more or less: shows how much of a figure is chance.
void AddNoise(std::uint32_t seed, std::vector<StereoFrame>& frames);

}  // namespace terrace
