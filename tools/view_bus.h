// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <lcm/lcm-cpp.hpp>

#include "client/terrain_client.h"
#include "client/terrain_query.h"
#include "lcmtypes/channels.h"
#include "tools/view_images.h"
#include "tools/view_requests.h"
#include "tools/view_server.h"

namespace terrace {

/// Listens to a daemon, as any subscriber, and hands what it hears to a server. Listens to camera images, and
/// asks for the octree and the disparity image, only while a browser wants them.
class ViewBus {
 public:
  /// Listens inside lcm->handle(). Both must outlive it. Throws std::runtime_error when LCM refuses.
  ViewBus(lcm::LCM* lcm, const ChannelConfig& channels, ViewServer* server);

  // To be called before and after every handle():
  void ListenToWhatIsWanted();
  void TakeMap();

 private:
  void OnPose(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnStatus(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnReply(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnCalibration(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnImages(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnPlan(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnOctree(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnDisparity(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void Pass(ViewBytes event);
  void Pass(ViewSlot slot, ViewBytes record);
  const TerrainQuery* QueryToMap();

  lcm::LCM* const lcm_;
  ViewServer* const server_;
  const ChannelConfig channels_;
  TerrainClient terrain_;
  TerrainMapPtr map_;
  std::unique_ptr<TerrainQuery> query_;  // to the map that was asked last
  ViewImages images_;
  ViewRequests requests_;
  lcm::Subscription* image_subscription_ = nullptr;
  std::int64_t t_image_us_ = 0;  // heard, the last one that was passed on
};

/// Sends "pause", "resume", "reset", "snapshot" or "save" to the daemon; others are passed over.
void SendViewCommand(const std::string& name, lcm::LCM* lcm, const std::string& channel);

}  // namespace terrace
