// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/sensor_frame.h"

namespace terrace {

/// Gives one pair after the other; nothing at the end. What cannot be read is a pair with a problem.
using NextPair = std::function<std::optional<StereoPair>()>;

/// Images that hold both cameras, the left one in the left half: a folder of files named by frame or by time,
/// or a video file. Throws SequenceError when it is neither.
/// @param rate_hz  counts the frames instead of what names or video say of time; none: only where they say
/// nothing
NextPair OpenSideBySide(const std::filesystem::path& path, std::optional<double> rate_hz);

}  // namespace terrace
