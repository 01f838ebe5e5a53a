// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_text.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/print.h"

namespace terrace {
namespace {

/// Keeps the order in which members are added.
using Json = nlohmann::ordered_json;

/// Steps this near are what a single frame must resolve.
constexpr double kNearSteps_m = 2.5;

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

/// "1" and "2.5" for lengths in names.
std::string Plain(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", number);
  return text;
}

Json TrajectoryJson(const TrajectoryEvaluation& trajectory) {
  Json json;
  json["ate_rmse_m"] = trajectory.num_matched > 0 ? Json(trajectory.ate_rmse_m) : Json(nullptr);
  json["coverage"] = trajectory.coverage;
  for (double length_m : {1.0, 2.0, 5.0, 10.0}) {
    const SegmentError* segment = trajectory.Segment(length_m);
    const std::string name = "rpe" + Plain(length_m) + "m_";
    json[name + "pct"] = segment ? Json(segment->translation_pct) : Json(nullptr);
    json[name + "deg_per_m"] = segment ? Json(segment->rotation_deg_per_m) : Json(nullptr);
  }
  json["num_truth"] = trajectory.num_truth;
  json["num_matched"] = trajectory.num_matched;
  json["path_length_m"] = trajectory.path_length_m;
  json["ate_mean_m"] = trajectory.ate_mean_m;
  json["ate_max_m"] = trajectory.ate_max_m;
  json["ate_first_pose_rmse_m"] = trajectory.ate_first_pose_rmse_m;
  json["rotation_rmse_deg"] = trajectory.rotation_rmse_deg;
  json["end_error_pct"] = trajectory.end_error_pct;
  const auto mean = [](const SegmentError& error) {
    Json of;
    of["count"] = error.count;
    of["translation_pct"] = error.count > 0 ? Json(error.translation_pct) : Json(nullptr);
    of["rotation_deg_per_m"] = error.count > 0 ? Json(error.rotation_deg_per_m) : Json(nullptr);
    return of;
  };
  json["segments"] = Json::array();
  for (const SegmentError& segment : trajectory.segments) {
    Json one;
    one["length_m"] = segment.length_m;
    one.update(mean(segment));
    json["segments"].push_back(one);
  }
  json["mean_of_all"] = mean(trajectory.mean_of_all);
  json["mean_of_kitti"] = mean(trajectory.mean_of_kitti);
  const CovarianceCalibration& covariance = trajectory.covariance;
  json["covariance"] = {{"count", covariance.count},
                        {"nees", covariance.mean_nees},
                        {"nees_rotation", covariance.mean_nees_rotation},
                        {"nees_translation", covariance.mean_nees_translation},
                        {"share_within_95", covariance.share_within_95}};
  return json;
}

Json PolygonJson(const PolygonEvaluation& polygon) {
  Json json;
  json["id"] = polygon.id;
  json["name"] = polygon.name;
  json["label"] = polygon.label;
  json["seen_m2"] = polygon.seen_m2;
  json["coverage"] = polygon.coverage();
  json["correct_m2"] = polygon.correct_m2;
  json["label_found"] = polygon.label_found.empty() ? Json(nullptr) : Json(polygon.label_found);
  json["plane_rms_m"] = polygon.plane_rms_m;
  json["plane_bias_m"] = polygon.plane_bias_m;
  json["normal_deg"] = polygon.normal_deg;
  json["num_regions"] = polygon.num_regions;
  json["edge_median_m"] = polygon.num_edge_samples > 0 ? Json(polygon.edge_median_m) : Json(nullptr);
  return json;
}

Json MapJson(const MapEvaluation& map) {
  Json json;
  json["coverage"] = map.coverage;
  json["ghost_area"] = map.ghost_area;
  json["support_plane_rms_m"] = map.support_plane_rms_m;
  json["iou"] = Json::object();
  json["labels"] = Json::object();
  for (const auto& [name, label] : map.labels) {
    if (label.true_m2 > 0.0) json["iou"][name] = label.iou();
    json["labels"][name] = {
        {"true_m2", label.true_m2}, {"correct_m2", label.correct_m2}, {"false_m2", label.false_m2}};
  }
  json["mean_iou"] = map.mean_iou();
  json["label_accuracy"] = map.label_accuracy;
  json["true_m2"] = map.true_m2;
  json["result_m2"] = map.result_m2;
  json["plane_rms_m"] = map.plane_rms_m;
  json["plane_p95_m"] = map.plane_p95_m;
  json["normal_mean_deg"] = map.normal_mean_deg;
  json["normal_p95_deg"] = map.normal_p95_deg;
  json["edge_median_m"] = map.edge_median_m;
  json["edge_p95_m"] = map.edge_p95_m;
  json["edge_bias_m"] = map.edge_bias_m;
  json["over_segmentation"] = map.over_segmentation;
  json["under_segmentation"] = map.under_segmentation;
  json["confusion_m2"] = map.confusion_m2;
  json["polygons"] = Json::array();
  for (const PolygonEvaluation& polygon : map.polygons) json["polygons"].push_back(PolygonJson(polygon));
  return json;
}

Json StaircasesJson(const StaircaseEvaluation& staircases) {
  Json json;
  json["precision"] = staircases.precision;
  json["recall"] = staircases.recall;
  json["num_true"] = staircases.num_true;
  json["num_result"] = staircases.num_result;
  json["num_found"] = staircases.num_found;
  json["matches"] = Json::array();
  for (const StaircaseMatch& match : staircases.matches) {
    const bool found = match.result_id.has_value();
    const auto of_found = [&](auto value) { return found ? Json(value) : Json(nullptr); };
    Json one;
    one["true_id"] = match.true_id;
    one["result_id"] = OrNull(match.result_id);
    one["num_risers_true"] = match.num_risers_true;
    one["num_risers_error"] = of_found(match.num_risers_error);
    one["riser_error_m"] = of_found(match.riser_error_m);
    one["tread_error_m"] = of_found(match.tread_error_m);
    one["width_error_m"] = of_found(match.width_error_m);
    one["direction_error_deg"] = of_found(match.direction_error_deg);
    one["base_error_m"] = of_found(match.base_error_m);
    one["first_reported_m"] = OrNull(match.first_reported_m);
    one["first_right_m"] = OrNull(match.first_right_m);
    json["matches"].push_back(one);
  }
  return json;
}

Json ErrorsJson(const DisparityErrors& errors) {
  Json json;
  json["num_visible"] = errors.num_visible();
  json["density_pct"] = errors.density_pct();
  for (double bad_px : {0.5, 1.0, 2.0}) {
    json["bad" + Plain(bad_px) + "_all_pct"] = errors.bad_all_pct(bad_px);
    json["bad" + Plain(bad_px) + "_valid_pct"] = errors.bad_valid_pct(bad_px);
  }
  json["d1_all_pct"] = errors.d1_all_pct();
  json["d1_valid_pct"] = errors.d1_valid_pct();
  json["average_px"] = errors.average_px();
  json["rms_px"] = errors.rms_px();
  json["invented_pct"] = errors.invented_pct();
  json["num_hidden"] = errors.num_hidden();
  json["lock_px"] = errors.lock_px();
  json["bias_px"] = errors.bias_px();
  return json;
}

Json PlanesJson(const PlaneFigures& planes) {
  return {{"count", planes.count},
          {"offset_px", planes.offset_px},
          {"offset_mm", planes.offset_mm},
          {"angle_deg", planes.angle_deg}};
}

Json DisparityJson(const DisparityEvaluation& disparity) {
  Json json;
  json["num_images"] = disparity.num_images;
  json.update(ErrorsJson(disparity.errors));
  json["planes"] = PlanesJson(disparity.Planes({}, 1e9));
  json["near_steps"] = PlanesJson(disparity.Planes({"stair_tread", "stair_riser"}, kNearSteps_m));
  json["edge_median_px"] = disparity.edges.empty() ? Json(nullptr) : Json(disparity.edge_median_px());
  json["num_edges"] = disparity.edges.size();
  return json;
}

Json TimeJson(const Evaluation& evaluation) {
  const ReplayStats& stats = evaluation.stats;
  Json json;
  json["frames"] = stats.frames;
  json["tracked"] = stats.tracked;
  json["dropped"] = stats.dropped;
  json["rate_hz"] = stats.rate_hz;
  json["peak_rss_mib"] = stats.peak_rss_mib;
  json["map_bytes"] = stats.map_bytes;
  json["map_cells"] = stats.map_cells;
  json["regions"] = evaluation.result_map.regions.size();
  json["latency_ms"] = nullptr;
  if (stats.latency) {
    json["latency_ms"] = {{"p50", stats.latency->p50},
                          {"p90", stats.latency->p90},
                          {"p99", stats.latency->p99},
                          {"max", stats.latency->max}};
  }
  json["latency_growth"] = nullptr;
  if (evaluation.latency_growth) {
    json["latency_growth"] = {{"ms_per_1000_cells", evaluation.latency_growth->ms_per_1000_cells},
                              {"ms_per_100_regions", evaluation.latency_growth->ms_per_100_regions}};
  }
  json["stages"] = Json::object();
  for (const auto& [name, stage] : stats.StagesInOrder()) {
    json["stages"][name] = {{"count", stage.count},   {"cpu_ms_mean", stage.cpu_ms_mean},
                            {"p50_ms", stage.p50_ms}, {"p90_ms", stage.p90_ms},
                            {"p99_ms", stage.p99_ms}, {"max_ms", stage.max_ms}};
  }
  return json;
}

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

void PrintMap(const MapEvaluation& map, std::string* text) {
  Print(text, "map          coverage %.1f %%, ghosts %.1f %%, label right on %.1f %% of what is covered\n",
        100 * map.coverage, 100 * map.ghost_area, 100 * map.label_accuracy);
  Print(text, "  planes     support %.1f mm rms; all %.1f mm rms, 95 %% within %.1f mm; normal %.2f deg\n",
        1e3 * map.support_plane_rms_m, 1e3 * map.plane_rms_m, 1e3 * map.plane_p95_m, map.normal_mean_deg);
  Print(text, "  edges      %.0f mm median, 95 %% within %.0f mm, bias %+.0f mm\n", 1e3 * map.edge_median_m,
        1e3 * map.edge_p95_m, 1e3 * map.edge_bias_m);
  Print(text, "  pieces     %.2f regions a polygon, %.2f polygons a region\n", map.over_segmentation,
        map.under_segmentation);
  for (const auto& [name, label] : map.labels) {
    if (label.true_m2 > 0.0) {
      Print(text, "  IoU        %-12s %.3f  (true %.2f m2, right %.2f, false %.2f)\n", name.c_str(),
            label.iou(), label.true_m2, label.correct_m2, label.false_m2);
    }
  }
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
  const PlaneFigures steps = disparity.Planes({"stair_tread", "stair_riser"}, kNearSteps_m);
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

std::string ToJson(const Evaluation& evaluation) {
  Json json;
  json["format"] = "terrace-evaluation";
  json["version"] = 1;
  json["result"] = evaluation.result.string();
  json["sequence"] = evaluation.sequence.string();
  json["notes"] = evaluation.notes;
  if (evaluation.trajectory) json["trajectory"] = TrajectoryJson(*evaluation.trajectory);
  if (evaluation.map) json["map"] = MapJson(*evaluation.map);
  if (evaluation.staircases) json["staircases"] = StaircasesJson(*evaluation.staircases);
  if (evaluation.disparity) json["disparity"] = DisparityJson(*evaluation.disparity);
  json["time"] = TimeJson(evaluation);
  return json.dump(1) + "\n";
}

std::string ToJson(const DisparityErrors& errors) { return ErrorsJson(errors).dump() + "\n"; }

std::string ToTable(const Evaluation& evaluation) {
  std::string text;
  if (evaluation.trajectory) PrintTrajectory(*evaluation.trajectory, &text);
  if (evaluation.map) PrintMap(*evaluation.map, &text);
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
