// SPDX-License-Identifier: BSD-3-Clause
#include "tools/family_jobs.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/file_bytes.h"
#include "datasets/synthetic/family.h"

namespace terrace {
namespace {

constexpr std::string_view kFamilyPrefix = "family:";
constexpr std::string_view kSeedsPrefix = "seeds=";
/// More would be a slip of the pen: each costs half a minute.
constexpr std::uint32_t kMaxSeeds = 10000;

struct SeedRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

std::uint32_t ParseSeed(std::string_view text, const std::string& where) {
  std::uint32_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size())
    throw FileError(where + ": the seed '" + std::string(text) + "' must be a whole number");
  return seed;
}

SeedRange ParseSeeds(std::string_view text, const std::string& where) {
  const std::size_t dash = text.find('-');
  SeedRange range;
  range.first = ParseSeed(text.substr(0, dash), where);
  range.last = dash == std::string_view::npos ? range.first : ParseSeed(text.substr(dash + 1), where);
  if (range.last < range.first || range.last - range.first >= kMaxSeeds)
    throw FileError(where + ": the seeds '" + std::string(text) + "' must be ONE or FIRST-LAST");
  return range;
}

}  // namespace

std::vector<EvaluationJob> ExpandFamily(const EvaluationJob& line, const std::string& where) {
  if (!line.sequence.starts_with(kFamilyPrefix)) return {line};
  std::istringstream parts(line.sequence);
  std::string family, part, options;
  std::getline(parts, family, ',');
  std::optional<SeedRange> seeds;
  while (std::getline(parts, part, ',')) {
    if (part.starts_with(kSeedsPrefix)) {
      seeds = ParseSeeds(std::string_view(part).substr(kSeedsPrefix.size()), where);
    } else {
      options += "," + part;
    }
  }
  if (!seeds) throw FileError(where + ": a family wants seeds=FIRST-LAST");
  std::vector<EvaluationJob> places;
  for (std::uint32_t k = 0; k <= seeds->last - seeds->first; ++k) {
    const std::string seed = std::to_string(seeds->first + k);
    places.push_back({line.name + "_" + seed, "scene:" + family + ",seed=" + seed + options,
                      line.replay_options, line.name});
  }
  return places;
}

std::vector<EvaluationJob> FamilyLines(const std::vector<std::string>& families, const std::string& seeds) {
  const std::vector<std::string> known = synthetic::FamilyNames();
  const bool all = std::find(families.begin(), families.end(), "all") != families.end();
  std::vector<EvaluationJob> lines;
  for (const std::string& family : all ? known : families) {
    if (std::find(known.begin(), known.end(), family) == known.end())
      throw FileError("--family: there is no family '" + family + "'");
    lines.push_back({family, "family:" + family + ",seeds=" + seeds, {}, ""});
  }
  return lines;
}

}  // namespace terrace
