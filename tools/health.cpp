// SPDX-License-Identifier: BSD-3-Clause
#include "tools/health.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/print.h"
#include "daemon/state_log.h"

namespace terrace {
namespace {

// An input that has been heard and then is not for this long has stopped; the slowest comes ten times a
// second.
constexpr double kSilentMs = 1000.0;
// Half a row is what a disparity of a tenth of a pixel on diagonal edges suffers from.
constexpr double kRowsOffPx = 0.5;
// With fewer pixels than this there is hardly a surface.
constexpr double kFewPixels = 0.15;
// A map that takes less than this share of the frames clears what has gone late.
constexpr double kSlowMap = 0.3;

using Findings = std::vector<Finding>;

Finding Trouble(std::string code, std::string text, std::string remedy) {
  return {Severity::kTrouble, std::move(code), std::move(text), std::move(remedy)};
}
Finding Note(std::string code, std::string text, std::string remedy) {
  return {Severity::kNote, std::move(code), std::move(text), std::move(remedy)};
}

/// "few features" as "few_features".
std::string CodeOf(ReasonCode reason) {
  std::string code = Name(reason);
  std::replace(code.begin(), code.end(), ' ', '_');
  return code;
}

void JudgeState(const Status& status, Findings* findings) {
  const std::string reason = status.reason.empty() ? std::string() : ": " + status.reason;
  switch (status.state) {
    case DaemonState::kRunning:
      if (status.tracking != TrackingStatus::kTracking)
        findings->push_back(
            Trouble("not_tracking", Name(status.tracking) + reason, RemedyFor(status.reason_code)));
      return;
    case DaemonState::kPaused:
      findings->push_back(Trouble("paused", "the map is paused; poses go on", "terrace command resume"));
      return;
    case DaemonState::kStarting:
      findings->push_back(Trouble("starting", "there is no map yet" + reason, RemedyFor(status.reason_code)));
      return;
    case DaemonState::kStopping:
      findings->push_back(Trouble("stopping", "the daemon is ending", ""));
      return;
    case DaemonState::kDegraded:
    case DaemonState::kNoInput:
    case DaemonState::kNoCalibration:
      break;
  }
  const std::string code = status.reason_code == ReasonCode::kNone || status.reason_code == ReasonCode::kOther
                               ? "degraded"
                               : CodeOf(status.reason_code);
  findings->push_back(Trouble(code, Name(status.state) + (", " + std::string(Name(status.tracking))) + reason,
                              RemedyFor(status.reason_code)));
}

void JudgeInputs(const Status& status, Findings* findings) {
  for (const InputStatus& input : status.inputs) {
    // Images have a state of their own; a calibration is needed once, commands and repairs come when they
    // come.
    const bool flows = input.name == "imu" || input.name == "body_prior" || input.name == "body_pose";
    if (flows && input.age_ms && *input.age_ms > kSilentMs) {
      findings->push_back(
          Trouble(input.name + "_silent",
                  Printed("nothing on %s for %.1f s", input.channel.c_str(), 1e-3 * *input.age_ms),
                  "its driver has stopped, or the network loses it"));
    }
  }
}

/// Counts that should stand still.
void JudgeCounts(const Status& status, const Status* before, Findings* findings) {
  const auto dropped = [](const Status& of) {
    std::int64_t sum = 0;
    for (const StageStatus& stage : of.stages)
      if (stage.name == "odometry") sum += stage.num_dropped;
    return sum;
  };
  struct Count {
    const char* code;
    const char* what;
    std::int64_t now;
    std::int64_t then;
    const char* remedy;
  };
  const Status nothing;
  const Status& old = before != nullptr ? *before : nothing;
  const std::array<Count, 6> counts = {
      Count{"bad_frames", "unreadable pairs of images", status.num_bad_frames, old.num_bad_frames,
            "size and format of what the camera sends: terrace doctor"},
      {"time_jumps", "jumps of the camera's clock", status.num_time_jumps, old.num_time_jumps,
       "stamps must come from one clock that is never set back"},
      {"decode_errors", "unreadable messages", status.num_decode_errors, old.num_decode_errors,
       "another type on one of the daemon's channels: terrace info LOG of a record tells which"},
      {"imu_gaps", "gaps in the IMU's samples", status.num_imu_gaps, old.num_imu_gaps,
       "the IMU's driver or the network loses samples"},
      {"frames_dropped", "frames without a pose", dropped(status), dropped(old),
       "the processor is too busy: terrace doctor"},
      {"deadline_missed", "maps later than lcm.deadline_ms", status.num_deadline_missed,
       old.num_deadline_missed, "the processor is too busy, or the camera's stamps are old: terrace doctor"}};
  for (const Count& count : counts) {
    if (count.now <= count.then) continue;
    std::string text = Printed("%lld %s", static_cast<long long>(count.now - count.then), count.what);
    if (before != nullptr) {
      findings->push_back(Trouble(count.code, std::move(text), count.remedy));
    } else {
      findings->push_back(Note(count.code, text + " since the start", count.remedy));
    }
  }
}

void JudgeQuality(const Status& status, Findings* findings) {
  if (status.map_seq == 0) return;  // nothing to judge yet
  if (std::abs(status.vertical_disparity_px) > kRowsOffPx) {
    findings->push_back(Trouble("rows_off",
                                Printed("rows of the pair are off by %.2f px", status.vertical_disparity_px),
                                "terrace calibration --check RECORD; calibrate anew when it agrees"));
  }
  if (status.dense_ratio < kFewPixels) {
    findings->push_back(Note("few_pixels",
                             Printed("%.0f %% of the pixels have a distance", 100.0 * status.dense_ratio),
                             "light, exposure, focus; a swapped or wrong calibration"));
  }
  if (status.fps_in > 0.0 && status.fps_out < kSlowMap * status.fps_in) {
    findings->push_back(
        Note("slow_map", Printed("%.1f of %.1f frames a second are mapped", status.fps_out, status.fps_in),
             "a free core, a smaller image, stereo.tier fast"));
  }
  if (status.gravity_source == GravitySource::kAssumed) {
    findings->push_back(Note("gravity_assumed",
                             "which way is down is only assumed: labels are at most half sure",
                             "give an IMU or body attitude, or camera.mounting"));
  }
}

nlohmann::json InputsJson(const Status& status) {
  nlohmann::json all = nlohmann::json::array();
  for (const InputStatus& input : status.inputs) {
    all.push_back({{"name", input.name},
                   {"channel", input.channel},
                   {"n_messages", input.num_messages},
                   {"n_bad", input.num_bad},
                   {"rate_hz", input.rate_hz},
                   {"age_ms", input.age_ms ? nlohmann::json(*input.age_ms) : nlohmann::json()}});
  }
  return all;
}

nlohmann::json StagesJson(const Status& status) {
  nlohmann::json all = nlohmann::json::array();
  for (const StageStatus& stage : status.stages) {
    all.push_back({{"name", stage.name},
                   {"n_in", stage.num_in},
                   {"n_out", stage.num_out},
                   {"n_dropped", stage.num_dropped},
                   {"queue_depth", stage.queue_depth},
                   {"ms_p50", stage.p50_ms},
                   {"ms_p99", stage.p99_ms},
                   {"ms_max", stage.max_ms}});
  }
  return all;
}

}  // namespace

std::vector<Finding> JudgeStatus(const Status& status, const Status* before) {
  Findings findings;
  JudgeState(status, &findings);
  JudgeInputs(status, &findings);
  JudgeCounts(status, before, &findings);
  JudgeQuality(status, &findings);
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

std::string StatusPage(const Status& status, const std::vector<Finding>& findings) {
  std::string page = Printed("terraced %s, up %.0f s: %s, %s, epoch %d, map %lld\n", status.version.c_str(),
                             1e-3 * static_cast<double>(status.uptime_ms), Name(status.state),
                             Name(status.tracking), status.epoch, static_cast<long long>(status.map_id));
  page += Printed("  frames   %.1f in, %.1f mapped a second; %.0f ms old when mapped (99 %%: %.0f ms)\n",
                  status.fps_in, status.fps_out, status.age_p50_ms, status.age_p99_ms);
  page += Printed("  odometry %d of %d landmarks agree, %.2f px; rows off by %+.2f px; gravity from %s\n",
                  status.num_inliers, status.num_matches, status.rms_px, status.vertical_disparity_px,
                  Name(status.gravity_source));
  page +=
      Printed("  map      %d regions, %lld cells, %.1f MB; process %.0f MB, %.2f cores\n", status.num_regions,
              static_cast<long long>(status.num_octree_nodes), 1e-6 * static_cast<double>(status.map_bytes),
              1e-6 * static_cast<double>(status.rss_bytes), status.cpu);
  for (const InputStatus& input : status.inputs) {
    page += Printed("  input    %-12s %-24s %7.1f Hz, %lld messages", input.name.c_str(),
                    input.channel.c_str(), input.rate_hz, static_cast<long long>(input.num_messages));
    if (input.num_bad > 0) page += Printed(", %lld bad", static_cast<long long>(input.num_bad));
    page += input.age_ms ? Printed(", newest %.0f ms ago\n", *input.age_ms) : std::string(", none yet\n");
  }
  for (const StageStatus& stage : status.stages) {
    if (stage.num_in == 0 && stage.num_dropped == 0) continue;
    page +=
        Printed("  stage    %-13s %6.1f ms, 99 %%: %6.1f ms, %d waiting, %lld dropped\n", stage.name.c_str(),
                stage.p50_ms, stage.p99_ms, stage.queue_depth, static_cast<long long>(stage.num_dropped));
  }
  for (const Finding& finding : findings) page += InWords(finding);
  return page + (AnyTrouble(findings) ? "not healthy\n" : "healthy\n");
}

std::string StatusJson(const Status& status, const std::vector<Finding>& findings) {
  nlohmann::json found = nlohmann::json::array();
  for (const Finding& finding : findings) {
    found.push_back({{"severity", Name(finding.severity)},
                     {"code", finding.code},
                     {"text", finding.text},
                     {"remedy", finding.remedy}});
  }
  const nlohmann::json all = {{"healthy", !AnyTrouble(findings)},
                              {"findings", found},
                              {"utime", status.t.ns / 1000},
                              {"seq", status.seq},
                              {"version", status.version},
                              {"config_hash", status.config_hash},
                              {"uptime_ms", status.uptime_ms},
                              {"state", Name(status.state)},
                              {"tracking", Name(status.tracking)},
                              {"gravity_source", Name(status.gravity_source)},
                              {"reason", status.reason},
                              {"reason_code", static_cast<int>(status.reason_code)},
                              {"map_id", status.map_id},
                              {"map_seq", status.map_seq},
                              {"epoch", status.epoch},
                              {"fps_in", status.fps_in},
                              {"fps_out", status.fps_out},
                              {"age_p50_ms", status.age_p50_ms},
                              {"age_p99_ms", status.age_p99_ms},
                              {"age_max_ms", status.age_max_ms},
                              {"n_deadline_missed", status.num_deadline_missed},
                              {"n_bad_frames", status.num_bad_frames},
                              {"n_time_jumps", status.num_time_jumps},
                              {"n_decode_errors", status.num_decode_errors},
                              {"n_imu_gaps", status.num_imu_gaps},
                              {"n_lost", status.num_lost},
                              {"vo_matches", status.num_matches},
                              {"vo_inliers", status.num_inliers},
                              {"vo_rms_px", status.rms_px},
                              {"dense_ratio", status.dense_ratio},
                              {"vertical_disparity_px", status.vertical_disparity_px},
                              {"octree_nodes", status.num_octree_nodes},
                              {"n_regions", status.num_regions},
                              {"map_bytes", status.map_bytes},
                              {"rss_bytes", status.rss_bytes},
                              {"cpu", status.cpu},
                              {"inputs", InputsJson(status)},
                              {"stages", StagesJson(status)}};
  return all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace terrace
