// SPDX-License-Identifier: BSD-3-Clause
#include <optional>
#include <string>

#include "core/print.h"
#include "evaluation/evaluation_text.h"

namespace terrace {
namespace {

/// Steps this near are what a single frame must resolve.
constexpr double kNearTableSteps_m = 2.5;

void PrintTrajectory(const TrajectoryEvaluation& trajectory, std::string* text) {
  Print(text, "trajectory   coverage %.1f %% (%lld of %lld), path %.2f m\n", 100 * trajectory.coverage,
        static_cast<long long>(trajectory.num_matched), static_cast<long long>(trajectory.num_truth),
        trajectory.path_length_m);
  if (trajectory.num_matched == 0) return;
  Print(text, "  ATE        %.1f mm rms, %.1f mm max; %.1f mm rms from the first pose\n",
        1e3 * trajectory.ate_rmse_m, 1e3 * trajectory.ate_max_m, 1e3 * trajectory.ate_first_pose_rmse_m);
  for (const SegmentError& segment : trajectory.segments) {
    Print(text, "  over %3g m %6.3f %%  %.4f deg/m  (%d starts)\n", segment.length_m, segment.translation_pct,
          segment.rotation_deg_per_m, segment.count);
  }
  if (trajectory.covariance.count > 0) {
    Print(text,
          "  NEES       %.2f (6 is honest); rotation %.2f, translation %.2f (3 each); %.0f %% within 95 %%\n",
          trajectory.covariance.mean_nees, trajectory.covariance.mean_nees_rotation,
          trajectory.covariance.mean_nees_translation, 100 * trajectory.covariance.share_within_95);
  }
}

void PrintEdges(const EdgeFigures& edges, std::string* text) {
  if (edges.count == 0) return;
  Print(text,
        "  edges      %.0f mm median, 95 %% within %.0f mm; of the covered %.1f, %.0f mm, bias %+.1f mm; "
        "%.1f %% not covered\n",
        1e3 * edges.median_m, 1e3 * edges.p95_m, 1e3 * edges.covered_median_m, 1e3 * edges.covered_p95_m,
        1e3 * edges.bias_m, 100 * edges.missed_share);
}

void PrintMap(const MapEvaluation& map, std::string* text) {
  Print(text, "map          coverage %.1f %%, ghosts %.1f %%, label right on %.1f %% of what is covered\n",
        100 * map.coverage, 100 * map.ghost_area, 100 * map.label_accuracy);
  Print(text, "  planes     support %.1f mm rms; all %.1f mm rms, 95 %% within %.1f mm; normal %.2f deg\n",
        1e3 * map.support_plane_rms_m, 1e3 * map.plane_rms_m, 1e3 * map.plane_p95_m, map.normal_mean_deg);
  PrintEdges(map.edges, text);
  Print(text, "  pieces     %.2f regions a polygon, %.2f polygons a region\n", map.over_segmentation,
        map.under_segmentation);
  for (const auto& [name, label] : map.labels) {
    if (label.true_m2 > 0.0) {
      Print(text, "  IoU        %-12s %.3f  (true %.2f m2, right %.2f, false %.2f)\n", name.c_str(),
            label.iou(), label.true_m2, label.correct_m2, label.false_m2);
    }
  }
}

/// "12.3 %", or a dash.
std::string PercentOrDash(const std::optional<double>& percent) {
  std::string text;
  if (!percent) return "-";
  Print(&text, "%.2f %%", *percent);
  return text;
}

void PrintFeet(const FeetEvaluation& feet, std::string* text) {
  Print(text, "feet         unsupported %s of %.2f m2 offered (%.0f cm2 on treads, %.0f cm2 near drops)\n",
        PercentOrDash(feet.unsupported_pct()).c_str(), feet.foothold_m2, 1e4 * feet.unsupported_tread_m2,
        1e4 * feet.unsupported_drop_m2);
  Print(text, "  offered    %s of %.2f m2 well seen\n", PercentOrDash(feet.offered_pct()).c_str(),
        feet.well_seen_m2);
  if (!feet.treads.empty()) {
    Print(text,
          "  treads     %s offered, mean of %zu; worst %s:", PercentOrDash(feet.tread_offered_pct()).c_str(),
          feet.treads.size(), PercentOrDash(feet.tread_offered_min_pct()).c_str());
    for (const TreadFeet& tread : feet.treads) Print(text, " %.0f", tread.offered_pct());
    *text += "\n";
  }
  PrintEdges(feet.edges, text);
  if (feet.drop_over_p100_m)
    Print(text, "  drops      outlines reach past them by %.0f mm at most\n", 1e3 * *feet.drop_over_p100_m);
}

void PrintStaircases(const StaircaseEvaluation& staircases, std::string* text) {
  Print(text, "staircases   %d of %d found, %d reported\n", staircases.num_found, staircases.num_true,
        staircases.num_result);
  for (const StaircaseMatch& match : staircases.matches) {
    if (!match.result_id) {
      Print(text, "  %-10d not in the map at the end\n", match.true_id);
      continue;
    }
    Print(text,
          "  %-10d %+d of %d risers, riser %+.0f mm, tread %+.0f mm, width %+.0f mm, direction %.1f deg\n",
          match.true_id, match.num_risers_error, match.num_risers_true, 1e3 * match.riser_error_m,
          1e3 * match.tread_error_m, 1e3 * match.width_error_m, match.direction_error_deg);
    if (match.first_reported_m)
      Print(text, "             first reported %.2f m away\n", *match.first_reported_m);
    if (match.first_right_m) Print(text, "             first right %.2f m away\n", *match.first_right_m);
  }
}

void PrintErrors(const DisparityErrors& errors, std::string* text) {
  Print(text, "  density    %.2f %% of the pixels visible in both images, invented %.1f %% of the hidden\n",
        errors.density_pct(), errors.invented_pct());
  Print(text, "  of all     bad-0.5 %.2f %%  bad-1 %.2f %%  bad-2 %.2f %%  D1 %.2f %%\n",
        errors.bad_all_pct(0.5), errors.bad_all_pct(1.0), errors.bad_all_pct(2.0), errors.d1_all_pct());
  Print(text, "  of valid   bad-0.5 %.2f %%  bad-1 %.2f %%  bad-2 %.2f %%  D1 %.2f %%\n",
        errors.bad_valid_pct(0.5), errors.bad_valid_pct(1.0), errors.bad_valid_pct(2.0),
        errors.d1_valid_pct());
  Print(text, "  error      average %.3f px, rms %.3f px; lock %.4f px, bias %+.4f px\n", errors.average_px(),
        errors.rms_px(), errors.lock_px(), errors.bias_px());
}

void PrintDisparity(const DisparityEvaluation& disparity, std::string* text) {
  Print(text, "disparity    %d images\n", disparity.num_images);
  PrintErrors(disparity.errors, text);
  const PlaneFigures all = disparity.Planes({}, 1e9);
  const PlaneFigures steps = disparity.Planes({"stair_tread", "stair_riser"}, kNearTableSteps_m);
  Print(text, "  planes     %d: offset %.3f px, %.2f mm, angle %.2f deg (medians)\n", all.count,
        all.offset_px, all.offset_mm, all.angle_deg);
  Print(text, "  near steps %d: offset %.3f px, %.2f mm, angle %.2f deg\n", steps.count, steps.offset_px,
        steps.offset_mm, steps.angle_deg);
  Print(text, "  edges      %.2f px median of %zu\n", disparity.edge_median_px(), disparity.edges.size());
}

void PrintTime(const Evaluation& evaluation, std::string* text) {
  const ReplayStats& stats = evaluation.stats;
  Print(text, "time         %.2f frames/s, %lld of %lld tracked, %lld dropped, %.0f MiB at most\n",
        stats.rate_hz, static_cast<long long>(stats.tracked), static_cast<long long>(stats.frames),
        static_cast<long long>(stats.dropped), stats.peak_rss_mib);
  if (stats.latency) {
    Print(text, "  latency    50 %% %.0f ms, 90 %% %.0f ms, 99 %% %.0f ms, max %.0f ms\n", stats.latency->p50,
          stats.latency->p90, stats.latency->p99, stats.latency->max);
  }
  if (evaluation.latency_growth) {
    Print(text, "  growth     %+.3f ms per 1000 cells, %+.2f ms per 100 regions\n",
          evaluation.latency_growth->ms_per_1000_cells, evaluation.latency_growth->ms_per_100_regions);
  }
  for (const auto& [name, stage] : stats.StagesInOrder()) {
    Print(text, "  %-14s cpu %7.2f ms  50 %% %7.2f ms  99 %% %7.2f ms  max %7.2f ms\n", name.c_str(),
          stage.cpu_ms_mean, stage.p50_ms, stage.p99_ms, stage.max_ms);
  }
}

}  // namespace

std::string ToTable(const Evaluation& evaluation) {
  std::string text;
  if (evaluation.trajectory) PrintTrajectory(*evaluation.trajectory, &text);
  if (evaluation.map) PrintMap(*evaluation.map, &text);
  if (evaluation.feet) PrintFeet(*evaluation.feet, &text);
  if (evaluation.staircases) PrintStaircases(*evaluation.staircases, &text);
  if (evaluation.disparity) PrintDisparity(*evaluation.disparity, &text);
  PrintTime(evaluation, &text);
  for (const std::string& note : evaluation.notes) text += "note         " + note + "\n";
  return text;
}

std::string ToTable(const DisparityErrors& errors) {
  std::string text;
  PrintErrors(errors, &text);
  return text;
}

}  // namespace terrace
