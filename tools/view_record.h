// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/time.h"

namespace terrace {

/// What a record tells the page. viewer/src/records.ts is the reader.
enum class ViewRecordKind : char {
  kHello = 'H',      ///< JSON: who speaks (ViewHello)
  kFigures = 'F',    ///< JSON: figures and pictures of a finished run
  kCamera = 'C',     ///< JSON: the rectified left camera
  kTerrain = 'T',    ///< terrain_v1_t, always in one part: whole, changes, or what was seen again
  kPose = 'P',       ///< pose_v1_t
  kStatus = 'S',     ///< status_v1_t
  kReply = 'R',      ///< command_reply_v1_t
  kPlan = 'G',       ///< footstep_plan_v1_t
  kImage = 'I',      ///< the rectified left image as JPEG
  kDisparity = 'D',  ///< a disparity image as a picture (view_surroundings.h)
  kCells = 'V',      ///< cells of the octree beside the regions (view_surroundings.h)
  kPoints = 'N',     ///< points of a disparity image beside the regions (view_surroundings.h)
  kTruth = 'U',      ///< terrain_v1_t: the true surfaces, in the world of the result
  kTrueWay = 'W',    ///< x, y, z, ... (float32): where the left camera truly was, in the world of the result
};

/// A record as it travels. Shared by everybody who sends it.
using ViewBytes = std::shared_ptr<const std::string>;

/// @param t        when it happened
/// @param t_heard  when this program heard of it; 0: it was not live
ViewBytes MakeViewRecord(ViewRecordKind kind, Timestamp t, Timestamp t_heard, const void* content,
                         std::size_t size);
ViewBytes MakeViewRecord(ViewRecordKind kind, Timestamp t, const std::string& content);

/// A message of ours as a record.
template <typename Message>
ViewBytes MakeViewRecord(ViewRecordKind kind, Timestamp t, Timestamp t_heard, const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return MakeViewRecord(kind, t, t_heard, bytes.data(), bytes.size());
}

/// Records one behind the other, as a file or inside a page.
std::string ViewRecording(std::span<const ViewBytes> records);

/// Who speaks, as the page shows it.
struct ViewHello {
  std::string source;  ///< live, log, result, map, report
  std::string name;
  bool control = false;  ///< whether commands are passed on to the daemon
};
ViewBytes MakeHello(const ViewHello& hello);

}  // namespace terrace
