// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <terrace/calibration_v1_t.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/footstep_plan_v1_t.hpp>
#include <terrace/images_t.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/pose_v1_t.hpp>
#include <terrace/status_v1_t.hpp>

#include "client/terrain_follower.h"
#include "client/terrain_query.h"
#include "core/file_bytes.h"
#include "datasets/lcm_event_log.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "tools/view_feed.h"
#include "tools/view_images.h"
#include "tools/view_recording.h"
#include "tools/view_surroundings.h"

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
  LogListener(const std::string& name, std::int64_t period_us)
      : feed_({"log", name}), cursor_(&feed_), period_us_(period_us) {
    ViewSlots all;
    for (const ViewSlot slot : {ViewSlot::kImage, ViewSlot::kDisparity, ViewSlot::kCells, ViewSlot::kPoints})
      all.Add(slot);
    cursor_.SetWants(all);
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
      if (ViewBytes camera = message ? images_.SetCalibration(*message) : nullptr)
        feed_.Take(ViewSlot::kCamera, camera);
    } else if (event.channel == channels_.footsteps) {
      if (const auto message = SafeDecode<footstep_plan_v1_t>(data, size))
        feed_.Take(ViewSlot::kPlan, MakeViewRecord(ViewRecordKind::kPlan, t, t, data, size));
    } else {
      HearWhatIsLarge(event, t);
    }
    Take();
  }

  bool has_map() const { return follower_.map() != nullptr; }
  std::vector<ViewBytes> TakeRecords() { return std::move(records_); }

 private:
  /// No more often than every so long.
  void HearWhatIsLarge(const LcmEvent& event, Timestamp t) {
    std::int64_t& due_us = due_us_[event.channel];
    if (event.utime < due_us) return;
    const auto* data = event.data.data();
    const std::size_t size = event.data.size();
    bool taken = false;
    const auto take = [&](ViewSlot slot, ViewBytes record) {
      taken = taken || record != nullptr;
      if (record) feed_.Take(slot, std::move(record));
    };
    if (event.channel == channels_.images) {
      if (const auto message = SafeDecode<images_t>(data, size))
        take(ViewSlot::kImage, images_.Encode(*message, t));
    } else if (event.channel == channels_.octree) {
      if (const auto message = SafeDecode<octree_v1_t>(data, size))
        take(ViewSlot::kCells, CellsRecord(*message, t, QueryToMap()));
    } else if (event.channel == channels_.disparity) {
      if (const auto message = SafeDecode<disparity_v1_t>(data, size)) {
        take(ViewSlot::kDisparity, DisparityRecord(*message, t));
        take(ViewSlot::kPoints, PointsRecord(*message, t, QueryToMap()));
      }
    }
    if (taken) due_us = event.utime + period_us_;
  }

  const TerrainQuery* QueryToMap() {
    if (!follower_.map()) return nullptr;
    if (!query_ || &query_->map() != follower_.map().get())
      query_ = std::make_unique<TerrainQuery>(follower_.map(), query_.get());
    return query_.get();
  }

  void Take() {
    while (ViewBytes record = cursor_.Next()) records_.push_back(std::move(record));
  }

  const ChannelConfig channels_;
  ViewFeed feed_;
  ViewCursor cursor_;
  TerrainFollower follower_;
  ViewImages images_;
  std::unique_ptr<TerrainQuery> query_;  // to the map that was asked last
  const std::int64_t period_us_;
  std::map<std::string, std::int64_t> due_us_;  // by channel
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
