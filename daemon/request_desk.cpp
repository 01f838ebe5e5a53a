// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/request_desk.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/print.h"
#include "lcmtypes/request_codec.h"

namespace terrace {
namespace {

constexpr std::chrono::seconds kOnceMayWait(10);  // of a request for one answer that cannot be given yet

}  // namespace

std::string RequestDesk::ProblemOf(const TerrainRequest& request) {
  if (request.rate_hz != 0.0 && (request.rate_hz < kMinRate_hz || request.rate_hz > kMaxRate_hz))
    return Printed("rate = %g must be 0 or lie between %g and %g Hz", request.rate_hz, kMinRate_hz,
                   kMaxRate_hz);
  if (request.rate_hz > 0.0 && (request.duration.count() == 0 || request.duration > kMaxDuration))
    return Printed("duration_s = %g must lie above 0 and at %d at most: ask again before it ends",
                   Seconds(request.duration), static_cast<int>(kMaxDuration.count()));
  if (std::max(-request.box.min().minCoeff(), request.box.max().maxCoeff()) > kFarthest_m)
    return Printed("the box reaches farther than %g m", kFarthest_m);
  const double largest_m = request.box.sizes().maxCoeff();
  switch (request.kind) {
    case RequestKind::kHeightMap: {
      if (!(request.resolution_m >= 1e-3))
        return Printed("resolution = %g must be at least 0.001 m", request.resolution_m);
      const Eigen::Vector2d num = NumCells(request.box, request.resolution_m);
      if (!(num.prod() <= kMaxCells))
        return Printed("%.0f x %.0f cells are more than %d: ask for a smaller box or a coarser resolution",
                       num.x(), num.y(), kMaxCells);
      return "";
    }
    case RequestKind::kOctree:
    case RequestKind::kMap:
      if (!(largest_m <= kMaxBox_m))
        return Printed("an edge of the box has %g m, must have at most %g", largest_m, kMaxBox_m);
      return "";
    case RequestKind::kDisparity:
      break;
  }
  return "";
}

void RequestDesk::Take(const terrain_request_v1_t& message, Time now) {
  const std::lock_guard lock(mutex_);
  const std::optional<TerrainRequest> request = FromMessage(message);
  if (!request)
    return Reply(message.request_id, command_reply_v1_t::REFUSED,
                 "a value cannot be: `what` is 1 to 4, numbers are finite, box_min is not above box_max");
  const std::string problem = ProblemOf(*request);
  if (!problem.empty()) return Reply(request->id, command_reply_v1_t::REFUSED, problem);
  std::erase_if(standing_, [&](const auto& entry) { return entry.second.end < now; });
  if (standing_.size() >= kMaxRequests && !standing_.contains(request->id))
    return Reply(request->id, command_reply_v1_t::REFUSED,
                 Printed("%d requests are being answered already", static_cast<int>(kMaxRequests)));
  const bool once = request->rate_hz == 0.0;
  standing_[request->id] = {*request, now, now + (once ? kOnceMayWait : request->duration)};
  Reply(request->id, command_reply_v1_t::OK,
        once ? "with one of the next frames" : "until duration_s is over");
}

void RequestDesk::Refill(Time now) {
  if (t_budget_) {
    const double elapsed_s = std::chrono::duration<double>(now - *t_budget_).count();
    budget_bytes_ = std::min(kMaxBytesPerSecond, budget_bytes_ + kMaxBytesPerSecond * elapsed_s);
  }
  t_budget_ = now;
}

void RequestDesk::Answer(const AnswerSources& sources, Time now) {
  const std::lock_guard lock(mutex_);
  Refill(now);
  std::erase_if(standing_, [&](const auto& entry) { return entry.second.end < now; });
  if (standing_.empty()) query_.reset();
  if (budget_bytes_ <= 0.0) return;
  std::vector<Standing*> due;
  for (auto& [id, standing] : standing_)
    if (standing.due <= now) due.push_back(&standing);
  std::stable_sort(due.begin(), due.end(),
                   [](const Standing* a, const Standing* b) { return a->due < b->due; });
  for (Standing* standing : due) {
    const Outcome outcome = Answer(standing->request, sources);
    if (outcome == Outcome::kWaits) continue;
    if (outcome == Outcome::kRefused || standing->request.rate_hz == 0.0) {
      standing_.erase(standing->request.id);
      return;
    }
    const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / standing->request.rate_hz));
    // What could not be answered in time is not made up for.
    standing->due = std::max(standing->due + period, now - period);
    return;
  }
}

RequestDesk::Outcome RequestDesk::Answer(const TerrainRequest& request, const AnswerSources& sources) {
  const std::optional<Eigen::AlignedBox3d> box_world = BoxInWorld(request, sources);
  if (!box_world) return Outcome::kWaits;
  switch (request.kind) {
    case RequestKind::kHeightMap:
      Publish(channels_.height_map,
              HeightMapAnswer(QueryTo(sources.map), sources.map_id, *box_world, request.resolution_m));
      return Outcome::kAnswered;
    case RequestKind::kMap:
      for (const terrain_v1_t& part : MapAnswer(QueryTo(sources.map), sources.map_id, *box_world))
        Publish(channels_.map_box, part);
      return Outcome::kAnswered;
    case RequestKind::kDisparity:
      if (!sources.disparity) return Outcome::kWaits;
      Publish(channels_.disparity, DisparityAnswer(sources));
      return Outcome::kAnswered;
    case RequestKind::kOctree:
      return AnswerWithOctree(request, *box_world, sources);
  }
  return Outcome::kRefused;
}

RequestDesk::Outcome RequestDesk::AnswerWithOctree(const TerrainRequest& request,
                                                   const Eigen::AlignedBox3d& box_world,
                                                   const AnswerSources& sources) {
  if (sources.octree == nullptr) return Outcome::kWaits;
  std::vector<OccupiedLeaf> leaves = sources.octree->LeavesIn(box_world);
  if (leaves.size() > kMaxLeaves) {
    Reply(request.id, command_reply_v1_t::REFUSED,
          Printed("there are %zu leaves in the box, more than %zu: ask for a smaller one", leaves.size(),
                  kMaxLeaves));
    return Outcome::kRefused;
  }
  Publish(channels_.octree, OctreeAnswer(sources, std::move(leaves), box_world));
  return Outcome::kAnswered;
}

void RequestDesk::Reply(std::int64_t request_id, std::int8_t result, const std::string& text) {
  command_reply_v1_t reply{};
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  reply.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  reply.request_id = request_id;
  reply.result = result;
  reply.message = text;
  lcm_->publish(channels_.reply, &reply);
}

template <typename Message>
void RequestDesk::Publish(const std::string& channel, const Message& message) {
  lcm_->publish(channel, &message);
  budget_bytes_ -= message.getEncodedSize();
}

const TerrainQuery& RequestDesk::QueryTo(const TerrainMapPtr& map) {
  if (!query_ || &query_->map() != map.get()) query_ = std::make_unique<TerrainQuery>(map, query_.get());
  return *query_;
}

}  // namespace terrace
