// SPDX-License-Identifier: BSD-3-Clause
#include "tools/terrain_words.h"

#include <array>
#include <cmath>
#include <map>

#include "core/angles.h"
#include "core/print.h"

namespace terrace {
namespace {

// What is below this is noise to a reader.
constexpr double kWorthAWordM = 0.05;
constexpr double kWorthAWordM2 = 0.1;
constexpr double kWorthAWordOfHeightM = 0.005;

/// Without the sign of a number that prints as zero.
double Shown(double value, double unit) { return std::abs(value) < 0.5 * unit ? 0.0 : value; }

struct LabelTotals {
  int num_regions = 0;
  double area_m2 = 0.0;
};

std::array<LabelTotals, kNumTerrainLabels> TotalsOf(const TerrainMap& map) {
  std::array<LabelTotals, kNumTerrainLabels> totals;
  for (const auto& region : map.regions) {
    LabelTotals& of_label = totals[static_cast<std::size_t>(region->label)];
    ++of_label.num_regions;
    of_label.area_m2 += region->area_m2;
  }
  return totals;
}

std::string StaircaseInWords(const Staircase& stairs, const TerrainMap& map) {
  std::string text = Printed("%d risers of %.2f m, treads of %.2f m, %.1f m wide, foot ", stairs.num_risers,
                          stairs.riser_m, stairs.tread_m, stairs.width_m);
  return text + PlaceInWords(stairs.base_world(), map) + Printed(" (confidence %.2f)", stairs.confidence);
}

bool IsNews(const Staircase& before, const Staircase& after) {
  return before.num_risers != after.num_risers || before.num_treads != after.num_treads ||
         std::abs(before.riser_m - after.riser_m) > kWorthAWordOfHeightM ||
         std::abs(before.tread_m - after.tread_m) > 2.0 * kWorthAWordOfHeightM ||
         std::abs(before.width_m - after.width_m) > kWorthAWordM;
}

}  // namespace

std::string PlaceInWords(const Eigen::Vector3d& p_world, const TerrainMap& map) {
  const Eigen::Vector3d up = map.gravity.up_world();
  const Eigen::Vector3d forward_tilted = map.T_world_left.linear().col(2);
  const Eigen::Vector3d forward = (forward_tilted - up * up.dot(forward_tilted)).normalized();
  const Eigen::Vector3d left = up.cross(forward);
  const Eigen::Vector3d d = p_world - map.T_world_left.translation();
  std::string text = Printed("%.1f m %s", std::abs(d.dot(forward)), d.dot(forward) >= 0.0 ? "ahead" : "behind");
  if (std::abs(d.dot(left)) > 2.0 * kWorthAWordM) {
    text += Printed(", %.1f m to the %s", std::abs(d.dot(left)), d.dot(left) > 0.0 ? "left" : "right");
  }
  return text;
}

std::vector<std::string> ChangesInWords(const TerrainMapPtr& before, const TerrainMap& after) {
  std::vector<std::string> words;
  const bool same_map = before && before->map_id == after.map_id;
  if (before && !same_map) words.push_back("a new map begins");
  const auto old_totals = same_map ? TotalsOf(*before) : std::array<LabelTotals, kNumTerrainLabels>();
  const auto totals = TotalsOf(after);
  for (std::size_t i = 0; i < totals.size(); ++i) {
    const bool news = totals[i].num_regions != old_totals[i].num_regions ||
                      std::abs(totals[i].area_m2 - old_totals[i].area_m2) > kWorthAWordM2;
    if (!news) continue;
    words.push_back(Printed("%s: %d regions, %.1f m2", Name(static_cast<TerrainLabel>(i)), totals[i].num_regions,
                         totals[i].area_m2));
  }
  std::map<std::int64_t, const Staircase*> old_stairs;
  if (same_map) {
    for (const Staircase& stairs : before->staircases) old_stairs[stairs.id] = &stairs;
  }
  for (const Staircase& stairs : after.staircases) {
    const auto old = old_stairs.find(stairs.id);
    if (old == old_stairs.end() || IsNews(*old->second, stairs)) {
      words.push_back(Printed("staircase %lld: ", static_cast<long long>(stairs.id)) +
                      StaircaseInWords(stairs, after));
    }
    if (old != old_stairs.end()) old_stairs.erase(old);
  }
  for (const auto& [id, stairs] : old_stairs) {
    words.push_back(Printed("staircase %lld is gone", static_cast<long long>(id)));
  }
  return words;
}

std::string StatusInWords(const Status& status) {
  std::string text =
      Printed("%s, %s, %.1f of %.1f frames/s, age %.0f ms (99 %%: %.0f ms), %d regions, gravity from %s, ",
           Name(status.state), Name(status.tracking), status.fps_out, status.fps_in, status.age_p50_ms,
           status.age_p99_ms, status.num_regions, Name(status.gravity_source));
  text += Printed("%.1f cores, %.0f MB", status.cpu, static_cast<double>(status.rss_bytes) * 1e-6);
  const std::array<std::pair<const char*, std::int64_t>, 5> troubles = {
      std::pair{"bad frames", status.num_bad_frames},
      {"time jumps", status.num_time_jumps},
      {"unreadable messages", status.num_decode_errors},
      {"IMU gaps", status.num_imu_gaps},
      {"lost frames", status.num_lost}};
  for (const auto& [name, count] : troubles) {
    if (count > 0) text += Printed("; %lld %s", static_cast<long long>(count), name);
  }
  return status.reason.empty() ? text : text + ": " + status.reason;
}

std::string PoseInWords(const Eigen::Isometry3d& T_world_body, const Eigen::Vector3d& v_body) {
  constexpr double kCentimetre = 0.01;
  const Eigen::Vector3d& p = T_world_body.translation();
  const Eigen::Vector3d forward = T_world_body.linear().col(0);
  const double heading_deg = Degrees(std::atan2(forward.y(), forward.x()));
  const double pitch_deg = Degrees(std::asin(std::fmin(1.0, std::fmax(-1.0, forward.z()))));
  return Printed("at x %.2f y %.2f z %.2f m, heading %.0f deg, pitch %.0f deg, %.2f m/s",
              Shown(p.x(), kCentimetre), Shown(p.y(), kCentimetre), Shown(p.z(), kCentimetre),
              Shown(heading_deg, 1.0), Shown(pitch_deg, 1.0), v_body.norm());
}

}  // namespace terrace
