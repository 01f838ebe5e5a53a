// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_bus.h"

#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include <terrace/calibration_v1_t.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/footstep_plan_v1_t.hpp>
#include <terrace/images_t.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/pose_v1_t.hpp>
#include <terrace/status_v1_t.hpp>

#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "tools/view_surroundings.h"

namespace terrace {
namespace {

// More than an eye needs beside a moving map.
constexpr std::int64_t kImagePeriodUs = 95'000;

std::int64_t NowUs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

template <typename Message>
ViewBytes AsItCame(ViewRecordKind kind, const Message& message, const lcm::ReceiveBuffer* buffer) {
  return MakeViewRecord(kind, Timestamp::FromMicroseconds(message.utime),
                        Timestamp::FromMicroseconds(buffer->recv_utime), buffer->data, buffer->data_size);
}

}  // namespace

ViewBus::ViewBus(lcm::LCM* lcm, const ChannelConfig& channels, ViewServer* server)
    : lcm_(lcm),
      server_(server),
      channels_(channels),
      terrain_(lcm, channels),
      requests_(lcm, channels.request) {
  Subscribe<&ViewBus::OnPose>(lcm_, channels_.pose_state, this);
  Subscribe<&ViewBus::OnStatus>(lcm_, channels_.status, this);
  Subscribe<&ViewBus::OnReply>(lcm_, channels_.reply, this);
  Subscribe<&ViewBus::OnCalibration>(lcm_, channels_.calibration, this);
  Subscribe<&ViewBus::OnPlan>(lcm_, channels_.footsteps, this);
  // Of answers that are large, the newest one is enough.
  if (auto* octrees = Subscribe<&ViewBus::OnOctree>(lcm_, channels_.octree, this))
    octrees->setQueueCapacity(1);
  if (auto* disparities = Subscribe<&ViewBus::OnDisparity>(lcm_, channels_.disparity, this))
    disparities->setQueueCapacity(1);
}

void ViewBus::TakeMap() {
  TerrainMapPtr map = terrain_.map();
  if (map == map_) return;
  map_ = map;
  const Timestamp t_heard = Timestamp::FromMicroseconds(NowUs());
  server_->Change([map = std::move(map), t_heard](ViewFeed* feed) { feed->TakeMap(map, t_heard); });
}

void ViewBus::OnPose(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<pose_v1_t>(buffer->data, buffer->data_size);
  const auto pose = message ? FromMessage(*message) : std::nullopt;
  if (!pose) return;
  ViewBytes record = AsItCame(ViewRecordKind::kPose, *message, buffer);
  server_->Change([pose = *pose, record](ViewFeed* feed) { feed->TakePose(pose, record); });
}

void ViewBus::OnStatus(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
  if (message) Pass(AsItCame(ViewRecordKind::kStatus, *message, buffer));
}

void ViewBus::OnReply(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<command_reply_v1_t>(buffer->data, buffer->data_size);
  // That the daemon will send what this program asks for is no news; that it will not is.
  if (message && !requests_.TakeReply(*message)) Pass(AsItCame(ViewRecordKind::kReply, *message, buffer));
}

void ViewBus::OnCalibration(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<calibration_v1_t>(buffer->data, buffer->data_size);
  ViewBytes record = message ? images_.SetCalibration(*message) : nullptr;
  if (record) Pass(ViewSlot::kCamera, record);
}

void ViewBus::OnImages(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (buffer->recv_utime >= t_image_us_ && buffer->recv_utime < t_image_us_ + kImagePeriodUs) return;
  const auto message = SafeDecode<images_t>(buffer->data, buffer->data_size);
  ViewBytes record =
      message ? images_.Encode(*message, Timestamp::FromMicroseconds(buffer->recv_utime)) : nullptr;
  if (!record) return;
  t_image_us_ = buffer->recv_utime;
  Pass(ViewSlot::kImage, record);
}

void ViewBus::OnPlan(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<footstep_plan_v1_t>(buffer->data, buffer->data_size);
  if (message) Pass(ViewSlot::kPlan, AsItCame(ViewRecordKind::kPlan, *message, buffer));
}

void ViewBus::OnOctree(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!server_->wanted().Has(ViewSlot::kCells)) return;
  const auto message = SafeDecode<octree_v1_t>(buffer->data, buffer->data_size);
  if (message)
    Pass(ViewSlot::kCells,
         CellsRecord(*message, Timestamp::FromMicroseconds(buffer->recv_utime), QueryToMap()));
}

void ViewBus::OnDisparity(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const ViewSlots wanted = server_->wanted();
  if (!wanted.Has(ViewSlot::kDisparity) && !wanted.Has(ViewSlot::kPoints)) return;
  const auto message = SafeDecode<disparity_v1_t>(buffer->data, buffer->data_size);
  if (!message) return;
  const Timestamp t_heard = Timestamp::FromMicroseconds(buffer->recv_utime);
  if (wanted.Has(ViewSlot::kDisparity)) Pass(ViewSlot::kDisparity, DisparityRecord(*message, t_heard));
  if (wanted.Has(ViewSlot::kPoints)) Pass(ViewSlot::kPoints, PointsRecord(*message, t_heard, QueryToMap()));
}

const TerrainQuery* ViewBus::QueryToMap() {
  TerrainMapPtr map = terrain_.map();
  if (!map) return nullptr;
  if (!query_ || &query_->map() != map.get())
    query_ = std::make_unique<TerrainQuery>(std::move(map), query_.get());
  return query_.get();
}

void ViewBus::ListenToWhatIsWanted() {
  const ViewSlots slots = server_->wanted();
  requests_.Ask(slots);
  const bool wanted = slots.Has(ViewSlot::kImage);
  if (wanted == (image_subscription_ != nullptr)) return;
  if (wanted) {
    image_subscription_ = Subscribe<&ViewBus::OnImages>(lcm_, channels_.images, this);
    // The newest one is enough.
    if (image_subscription_ != nullptr) image_subscription_->setQueueCapacity(2);
  } else {
    lcm_->unsubscribe(image_subscription_);
    image_subscription_ = nullptr;
  }
}

void ViewBus::Pass(ViewBytes event) {
  server_->Change([event = std::move(event)](ViewFeed* feed) { feed->TakeEvent(event); });
}

/// Null: there is nothing to pass.
void ViewBus::Pass(ViewSlot slot, ViewBytes record) {
  if (!record) return;
  server_->Change([slot, record = std::move(record)](ViewFeed* feed) { feed->Take(slot, record); });
}

void SendViewCommand(const std::string& name, lcm::LCM* lcm, const std::string& channel) {
  static const std::map<std::string, std::int8_t> kCommands = {{"pause", command_v1_t::PAUSE},
                                                               {"resume", command_v1_t::RESUME},
                                                               {"reset", command_v1_t::RESET_MAP},
                                                               {"snapshot", command_v1_t::SEND_SNAPSHOT},
                                                               {"save", command_v1_t::SAVE_MAP}};
  const auto known = kCommands.find(name);
  if (known == kCommands.end()) return;
  command_v1_t command{};
  command.utime = NowUs();
  command.request_id = command.utime;
  command.command = known->second;
  if (name == "save") command.argument = "map_" + std::to_string(command.utime) + ".json";
  lcm->publish(channel, &command);
}

}  // namespace terrace
