// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/status_codec.h"

#include <optional>

#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

float Small(double v) { return static_cast<float>(v); }

/// What says in a message that nothing has arrived yet.
constexpr float kNoAge = -1.0F;

input_stat_v1_t ToMessage(const InputStatus& input) {
  input_stat_v1_t stat{};
  stat.name = input.name;
  stat.channel = input.channel;
  stat.n_messages = input.num_messages;
  stat.n_bad = input.num_bad;
  stat.rate = Small(input.rate_hz);
  stat.age_ms = input.age_ms ? Small(*input.age_ms) : kNoAge;
  return stat;
}

InputStatus FromMessage(const input_stat_v1_t& stat) {
  InputStatus input{stat.name, stat.channel, stat.n_messages, stat.n_bad, stat.rate, std::nullopt};
  if (stat.age_ms >= 0.0F) input.age_ms = stat.age_ms;
  return input;
}

stage_stat_v1_t ToMessage(const StageStatus& stage) {
  stage_stat_v1_t stat{};
  stat.name = stage.name;
  stat.n_in = stage.num_in;
  stat.n_out = stage.num_out;
  stat.n_dropped = stage.num_dropped;
  stat.queue_depth = stage.queue_depth;
  stat.ms_last = Small(stage.last_ms);
  stat.ms_p50 = Small(stage.p50_ms);
  stat.ms_p99 = Small(stage.p99_ms);
  stat.ms_max = Small(stage.max_ms);
  return stat;
}

}  // namespace

status_v1_t ToMessage(const Status& status) {
  status_v1_t message{};
  message.utime = status.t.utime();
  message.seq = status.seq;
  message.version = status.version;
  message.config_hash = status.config_hash;
  message.uptime_ms = status.uptime_ms;
  message.state = static_cast<std::int8_t>(status.state);
  message.source = static_cast<std::int8_t>(status.source);
  message.tracking = static_cast<std::int8_t>(status.tracking);
  message.gravity_source = static_cast<std::int8_t>(status.gravity_source);
  message.window_s = Small(status.window_s);
  message.reason = status.reason;
  message.reason_code = static_cast<std::int16_t>(status.reason_code);
  message.map_id = status.map_id;
  message.map_seq = status.map_seq;
  message.epoch = status.epoch;
  message.fps_in = Small(status.fps_in);
  message.fps_out = Small(status.fps_out);
  message.age_p50_ms = Small(status.age_p50_ms);
  message.age_p99_ms = Small(status.age_p99_ms);
  message.age_max_ms = Small(status.age_max_ms);
  message.n_deadline_missed = status.num_deadline_missed;
  message.n_bad_frames = status.num_bad_frames;
  message.n_time_jumps = status.num_time_jumps;
  message.n_decode_errors = status.num_decode_errors;
  message.n_imu_gaps = status.num_imu_gaps;
  message.n_lost = status.num_lost;
  message.vo_matches = status.num_matches;
  message.vo_inliers = status.num_inliers;
  message.vo_rms_px = Small(status.rms_px);
  message.dense_ratio = Small(status.dense_ratio);
  message.vertical_disparity_px = Small(status.vertical_disparity_px);
  message.octree_nodes = status.num_octree_nodes;
  message.n_regions = status.num_regions;
  message.map_bytes = status.map_bytes;
  message.rss_bytes = status.rss_bytes;
  message.cpu = Small(status.cpu);
  for (const InputStatus& input : status.inputs) message.inputs.push_back(ToMessage(input));
  message.n_inputs = static_cast<std::int32_t>(message.inputs.size());
  for (const StageStatus& stage : status.stages) message.stages.push_back(ToMessage(stage));
  message.n_stages = static_cast<std::int32_t>(message.stages.size());
  return message;
}

std::optional<Status> FromMessage(const status_v1_t& message) {
  const auto state = EnumFrom<DaemonState>(message.state, 7);
  const auto source = EnumFrom<InputSource>(message.source, 2);
  const auto tracking = EnumFrom<TrackingStatus>(message.tracking, 3);
  const auto gravity_source = EnumFrom<GravitySource>(message.gravity_source, 5);
  const auto t = TimeFromMicroseconds(message.utime);
  if (!state || !source || !tracking || !gravity_source || !t) return std::nullopt;
  Status status;
  status.t = *t;
  status.seq = message.seq;
  status.version = message.version;
  status.config_hash = message.config_hash;
  status.uptime_ms = message.uptime_ms;
  status.state = *state;
  status.source = *source;
  status.tracking = *tracking;
  status.gravity_source = *gravity_source;
  status.window_s = message.window_s;
  status.reason = message.reason;
  // A later daemon may know more reasons than this program.
  status.reason_code =
      EnumFrom<ReasonCode>(message.reason_code, kNumReasonCodes).value_or(ReasonCode::kOther);
  status.map_id = message.map_id;
  status.map_seq = message.map_seq;
  status.epoch = message.epoch;
  status.fps_in = message.fps_in;
  status.fps_out = message.fps_out;
  status.age_p50_ms = message.age_p50_ms;
  status.age_p99_ms = message.age_p99_ms;
  status.age_max_ms = message.age_max_ms;
  status.num_deadline_missed = message.n_deadline_missed;
  status.num_bad_frames = message.n_bad_frames;
  status.num_time_jumps = message.n_time_jumps;
  status.num_decode_errors = message.n_decode_errors;
  status.num_imu_gaps = message.n_imu_gaps;
  status.num_lost = message.n_lost;
  status.num_matches = message.vo_matches;
  status.num_inliers = message.vo_inliers;
  status.rms_px = message.vo_rms_px;
  status.dense_ratio = message.dense_ratio;
  status.vertical_disparity_px = message.vertical_disparity_px;
  status.num_octree_nodes = message.octree_nodes;
  status.num_regions = message.n_regions;
  status.map_bytes = message.map_bytes;
  status.rss_bytes = message.rss_bytes;
  status.cpu = message.cpu;
  for (const input_stat_v1_t& stat : message.inputs) status.inputs.push_back(FromMessage(stat));
  for (const stage_stat_v1_t& stat : message.stages) {
    status.stages.push_back({stat.name, stat.n_in, stat.n_out, stat.n_dropped, stat.queue_depth, stat.ms_last,
                             stat.ms_p50, stat.ms_p99, stat.ms_max});
  }
  return status;
}

}  // namespace terrace
