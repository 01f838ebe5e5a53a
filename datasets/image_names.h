// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/time.h"

namespace terrace {

/// The images of a folder by the numbers that their names are: frame numbers, or time stamps. PNG, JPEG and
/// PGM by their ending; other files are none.
struct ImageNames {
  /// Name by number: the frame, or nanoseconds since the epoch.
  std::map<std::int64_t, std::string> by_number;
  bool are_times = false;
};

/// @return no names when the folder cannot be read
ImageNames ListImageNames(const std::filesystem::path& folder);

/// A time stamp as recorders put it into names: nanoseconds, microseconds or milliseconds since the epoch as
/// a whole number, or seconds with decimals; none when it is none of these, as a frame number is.
std::optional<Timestamp> TimeOfName(const std::string& stem);

}  // namespace terrace
