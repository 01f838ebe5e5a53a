// SPDX-License-Identifier: BSD-3-Clause
#include "tools/result_server.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

#include <terrace/status_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>

#include "client/terrace_file.h"
#include "daemon/version.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/subscribe.h"

namespace terrace {
namespace {

constexpr double kSnapshotPeriod_s = 60.0;
constexpr std::chrono::milliseconds kPosePeriod(100);
constexpr std::chrono::seconds kStatusPeriod(1);

}  // namespace

TerrainMapPtr ServedMap(const ReplayResult& result) {
  auto map = std::make_shared<TerrainMap>(result.map);
  // The file of a map does not count its states.
  map->seq = 1;
  map->gravity = result.stats.gravity;
  map->T_body_left = result.camera.T_body_left;
  if (!result.frames.empty()) map->epoch = result.frames.back().epoch;
  if (result.trajectory.empty()) return map;
  map->T_world_left = result.trajectory.back().T_world_left;
  map->t_capture = std::max(map->t_capture, result.trajectory.back().t_capture);
  return map;
}

TerrainMapPtr MapToServe(const std::filesystem::path& result) {
  return result.extension() == ".terrace" ? LoadTerraceFile(result).map : ServedMap(ReadReplayResult(result));
}

ResultServer::ResultServer(lcm::LCM* lcm, TerrainMapPtr map, const ChannelConfig& channels)
    : lcm_(lcm),
      channels_(channels),
      map_(std::move(map)),
      publisher_(lcm, channels, map_->T_body_left, kSnapshotPeriod_s) {
  pose_.t_capture = map_->t_capture;
  pose_.T_world_left = map_->T_world_left;
  pose_.covariance = map_->covariance;
  pose_.status = TrackingStatus::kTracking;
  pose_.trusted = true;
  pose_.epoch = map_->epoch;
  subscription_ = Subscribe<&ResultServer::OnRepair>(lcm_, channels_.repair, this);
  if (subscription_ == nullptr) throw std::runtime_error("cannot listen on " + channels_.repair);
  MapChange whole;
  whole.map = map_;
  publisher_.PublishTerrain(whole);
}

ResultServer::~ResultServer() { lcm_->unsubscribe(subscription_); }

void ResultServer::Tick(Time now) {
  publisher_.Tick();
  if (!t_pose_ || now - *t_pose_ >= kPosePeriod) {
    t_pose_ = now;
    publisher_.PublishPose(pose_);
  }
  if (!t_status_ || now - *t_status_ >= kStatusPeriod) {
    t_status_ = now;
    PublishStatus();
  }
}

void ResultServer::PublishStatus() {
  Status status;
  status.t = map_->t_capture;
  status.seq = ++num_statuses_;
  status.version = kVersion;
  status.state = DaemonState::kRunning;
  status.source = InputSource::kReplay;
  status.tracking = pose_.status;
  status.gravity_source = map_->gravity.source;
  status.reason = "a finished map is served; nothing changes";
  status.num_regions = static_cast<int>(map_->regions.size());
  publisher_.Describe(&status);
  const status_v1_t message = ToMessage(status);
  lcm_->publish(channels_.status, &message);
}

void ResultServer::OnRepair(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto repair = SafeDecode<terrain_repair_v1_t>(buffer->data, buffer->data_size);
  if (repair) publisher_.Answer(*repair);
}

}  // namespace terrace
