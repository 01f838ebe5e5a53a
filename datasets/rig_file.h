// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "core/camera.h"

namespace terrace {

/// A rig as a file of our own format (`terrace-rig`, datasets/README.md): reading it back gives the same
/// calibration.
std::string PrintRigFile(const StereoCalibration& calibration);

}  // namespace terrace
