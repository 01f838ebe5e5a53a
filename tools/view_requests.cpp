// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_requests.h"

#include <utility>

#include <terrace/terrain_request_v1_t.hpp>

#include "lcmtypes/request_codec.h"

namespace terrace {
namespace {

constexpr std::chrono::seconds kRequestStands{12};
constexpr std::chrono::seconds kAskedAgain{5};
constexpr double kAnswerRate_hz = 2.0;
// Of the octree: what a robot may touch next. Where that is more than the daemon gives, less is asked for.
const Eigen::Vector3d kHalfBox_m(3.0, 3.0, 2.0);
constexpr double kSmallestHalfBox_m = 0.5;
constexpr double kBoxShrinks = 0.7;

std::int64_t ClockUs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

}  // namespace

ViewRequests::ViewRequests(lcm::LCM* lcm, std::string channel) : lcm_(lcm), channel_(std::move(channel)) {
  // Numbers that no other program uses, unless it began in the same microsecond.
  cells_.request.id = ClockUs();
  cells_.request.kind = RequestKind::kOctree;
  cells_.request.around_robot = true;
  cells_.request.box = {-kHalfBox_m, kHalfBox_m};
  disparity_.request.id = cells_.request.id + 1;
  disparity_.request.kind = RequestKind::kDisparity;
  for (Standing* standing : {&cells_, &disparity_}) standing->request.duration = kRequestStands;
}

void ViewRequests::Ask(const ViewSlots& wanted) {
  Ask(wanted.Has(ViewSlot::kCells), &cells_);
  Ask(wanted.Has(ViewSlot::kDisparity) || wanted.Has(ViewSlot::kPoints), &disparity_);
}

void ViewRequests::Ask(bool wanted, Standing* standing) {
  const Time now = std::chrono::steady_clock::now();
  if (!wanted && !standing->t_asked) return;
  if (wanted && standing->t_asked && now < *standing->t_asked + kAskedAgain) return;
  // One answer takes the place of many: nothing is sent any more once it is there.
  standing->request.rate_hz = wanted ? kAnswerRate_hz : 0.0;
  standing->t_asked = wanted ? std::optional(now) : std::nullopt;
  Publish(standing->request);
}

bool ViewRequests::TakeReply(const command_reply_v1_t& reply) {
  const bool is_cells = reply.request_id == cells_.request.id;
  if (!is_cells && reply.request_id != disparity_.request.id) return false;
  if (reply.result == command_reply_v1_t::OK) return true;
  const Eigen::Vector3d half_m = kBoxShrinks * cells_.request.box.max();
  if (!is_cells || !cells_.t_asked || half_m.minCoeff() < kSmallestHalfBox_m) return false;
  cells_.request.box = {-half_m, half_m};
  Publish(cells_.request);
  return true;
}

void ViewRequests::Publish(const TerrainRequest& request) {
  terrain_request_v1_t message = ToMessage(request);
  message.utime = ClockUs();
  lcm_->publish(channel_, &message);
}

}  // namespace terrace
