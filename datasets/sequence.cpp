// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/sequence.h"

#include "core/check.h"
#include "datasets/euroc.h"
#include "datasets/kitti.h"
#include "datasets/lcm_event_log.h"
#include "datasets/lcm_log.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Sequence> OpenAs(SequenceKind kind, const fs::path& path, const ChannelConfig& channels) {
  switch (kind) {
    case SequenceKind::kEuroc:
      return OpenEurocSequence(path);
    case SequenceKind::kKitti:
      return OpenKittiSequence(path);
    case SequenceKind::kLcmLog:
      return OpenLcmLogSequence(path, channels);
  }
  TERRACE_CHECK(false, static_cast<int>(kind));
}

}  // namespace

const char* Name(SequenceKind kind) {
  switch (kind) {
    case SequenceKind::kEuroc:
      return "EuRoC ASL folder";
    case SequenceKind::kKitti:
      return "KITTI odometry folder";
    case SequenceKind::kLcmLog:
      return "LCM log";
  }
  TERRACE_CHECK(false, static_cast<int>(kind));
}

std::optional<SequenceKind> RecogniseSequence(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path / "mav0", error)) return SequenceKind::kEuroc;
  for (const char* folder : {"image_0", "image_1", "image_2", "image_3"}) {
    if (fs::is_directory(path / folder, error)) return SequenceKind::kKitti;
  }
  if (fs::is_regular_file(path, error) && BeginsLikeLcmLog(path)) return SequenceKind::kLcmLog;
  return std::nullopt;
}

std::unique_ptr<Sequence> OpenSequence(const fs::path& path, const ChannelConfig& channels) {
  std::error_code error;
  if (!fs::exists(path, error)) throw SequenceError(path.string() + ": no such file or folder");
  const std::optional<SequenceKind> kind = RecogniseSequence(path);
  if (!kind) {
    throw SequenceError(
        path.string() +
        ": not a sequence; must be an EuRoC ASL folder (holds mav0/), a KITTI odometry folder (holds "
        "image_0/ and image_1/, or image_2/ and image_3/) or an LCM log");
  }
  try {
    return OpenAs(*kind, path, channels);
  } catch (const fs::filesystem_error& problem) {  // no permission, a loop of links
    throw SequenceError(problem.path1().string() + ": " + problem.code().message());
  }
}

}  // namespace terrace
