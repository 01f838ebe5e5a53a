// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include <terrace/calibration_v1_t.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/images_t.hpp>
#include <terrace/pose_v1_t.hpp>
#include <terrace/status_v1_t.hpp>

#include "client/terrain_follower.h"
#include "core/file_bytes.h"
#include "datasets/lcm_event_log.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "tools/view_feed.h"
#include "tools/view_images.h"
#include "tools/view_recording.h"

namespace terrace {
namespace {

// So many images that a recording of any length can be held by a browser.
constexpr std::int64_t kMaxImages = 600;
constexpr std::int64_t kMinImagePeriodUs = 200'000;

/// First and last time in a log.
std::int64_t DurationUs(const std::filesystem::path& file) {
  LcmEventReader reader(file);
  LcmEvent event;
  std::optional<std::int64_t> first;
  std::int64_t last = 0;
  while (reader.Next(&event)) {
    if (!first) first = event.utime;
    last = std::max(last, event.utime);
  }
  return first ? last - *first : 0;
}

/// Plays events into a feed, as the bus would, and takes what a browser that is never slow would be sent.
class LogListener {
 public:
  LogListener(const std::string& name, std::int64_t image_period_us)
      : feed_({"log", name}), cursor_(&feed_), image_period_us_(image_period_us) {
    cursor_.SetWantsImages(true);
    Take();
  }

  void Hear(const LcmEvent& event) {
    const Timestamp t = Timestamp::FromMicroseconds(event.utime);
    const auto* data = event.data.data();
    const std::size_t size = event.data.size();
    if (event.channel == channels_.pose_state) {
      const auto message = SafeDecode<pose_v1_t>(data, size);
      const auto pose = message ? FromMessage(*message) : std::nullopt;
      if (pose) feed_.TakePose(*pose, MakeViewRecord(ViewRecordKind::kPose, pose->t_capture, t, data, size));
    } else if (event.channel == channels_.status) {
      if (SafeDecode<status_v1_t>(data, size))
        feed_.TakeEvent(MakeViewRecord(ViewRecordKind::kStatus, t, t, data, size));
    } else if (event.channel == channels_.reply) {
      if (SafeDecode<command_reply_v1_t>(data, size))
        feed_.TakeEvent(MakeViewRecord(ViewRecordKind::kReply, t, t, data, size));
    } else if (event.channel == channels_.terrain) {
      const TerrainFollower::Time time{std::chrono::microseconds(event.utime)};
      if (follower_.Receive(data, size, time)) feed_.TakeMap(follower_.map(), t);
    } else if (event.channel == channels_.calibration) {
      const auto message = SafeDecode<calibration_v1_t>(data, size);
      if (ViewBytes camera = message ? images_.SetCalibration(*message) : nullptr) feed_.TakeCamera(camera);
    } else if (event.channel == channels_.images && event.utime >= next_image_us_) {
      const auto message = SafeDecode<images_t>(data, size);
      ViewBytes image = message ? images_.Encode(*message, t) : nullptr;
      if (!image) return;
      feed_.TakeImage(image);
      next_image_us_ = event.utime + image_period_us_;
    }
    Take();
  }

  bool has_map() const { return follower_.map() != nullptr; }
  std::vector<ViewBytes> TakeRecords() { return std::move(records_); }

 private:
  void Take() {
    while (ViewBytes record = cursor_.Next()) records_.push_back(std::move(record));
  }

  const ChannelConfig channels_;
  ViewFeed feed_;
  ViewCursor cursor_;
  TerrainFollower follower_;
  ViewImages images_;
  const std::int64_t image_period_us_;
  std::int64_t next_image_us_ = 0;
  std::vector<ViewBytes> records_;
};

}  // namespace

std::vector<ViewBytes> RecordsOfLog(const std::filesystem::path& file) {
  LogListener listener(file.filename().string(), std::max(kMinImagePeriodUs, DurationUs(file) / kMaxImages));
  LcmEventReader reader(file);
  LcmEvent event;
  while (reader.Next(&event)) listener.Hear(event);
  if (!listener.has_map()) {
    throw FileError(file.string() + ": holds no map of a daemon on " + ChannelConfig().terrain +
                    "; record a running daemon, or let terraced replay make a result of it");
  }
  return listener.TakeRecords();
}

}  // namespace terrace
