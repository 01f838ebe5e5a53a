// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "datasets/calibration_file.h"
#include "datasets/calibration_parts.h"

namespace terrace {

/// Puts together what several files say about one rig.
/// @param names  of the files, as long as `files`
RigReading AssembleRig(std::vector<CalibrationParts> files, const std::vector<std::string>& names,
                       const RigOptions& options);

}  // namespace terrace
