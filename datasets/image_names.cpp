// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_names.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "datasets/text_table.h"

namespace terrace {

std::optional<Timestamp> TimeOfName(const std::string& stem) {
  const std::size_t point = stem.find('.');
  const std::optional<std::int64_t> whole = ParseInt64(stem.substr(0, point));
  if (!whole || *whole < 0) return std::nullopt;
  if (point != std::string::npos) {
    // Not as a double: it has no room for nanoseconds since the epoch.
    std::string decimals = stem.substr(point + 1);
    const bool digits =
        std::all_of(decimals.begin(), decimals.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
    constexpr std::int64_t kMostSeconds = 9'000'000'000;
    if (decimals.empty() || !digits || *whole > kMostSeconds) return std::nullopt;
    decimals.resize(9, '0');
    return Timestamp{*whole * 1'000'000'000 + *ParseInt64(decimals)};
  }
  // Between the years 1973 and 5138 in any unit; smaller numbers are frames.
  constexpr std::int64_t kFirst = 100'000'000;
  for (const std::int64_t per_second :
       {std::int64_t{1'000'000'000}, std::int64_t{1'000'000}, std::int64_t{1'000}}) {
    if (*whole / per_second >= kFirst) return Timestamp{*whole * (1'000'000'000 / per_second)};
  }
  return std::nullopt;
}

ImageNames ListImageNames(const std::filesystem::path& folder) {
  ImageNames out;
  std::map<std::int64_t, std::string> times, frames;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::filesystem::path name = entry.path().filename();
    std::string ending = name.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    constexpr std::array kEndings = {".png", ".jpg", ".jpeg", ".pgm"};
    if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end()) continue;
    const std::string stem = name.stem().string();
    if (const auto time = TimeOfName(stem)) {
      times.emplace(time->ns, name.string());
    } else if (const auto number = ParseInt64(stem)) {
      frames.emplace(*number, name.string());
    }
  }
  out.are_times = times.size() > frames.size();
  out.by_number = out.are_times ? std::move(times) : std::move(frames);
  return out;
}

}  // namespace terrace
