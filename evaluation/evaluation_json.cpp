// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "evaluation/evaluation_text.h"

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
  json["edge_median_m"] = polygon.edges.count > 0 ? Json(polygon.edges.median_m) : Json(nullptr);
  return json;
}

void EdgeJson(const EdgeFigures& edges, Json* json) {
  const auto of_some = [&](double value) { return edges.count > 0 ? Json(value) : Json(nullptr); };
  (*json)["edge_median_m"] = of_some(edges.median_m);
  (*json)["edge_p95_m"] = of_some(edges.p95_m);
  (*json)["edge_covered_median_m"] = of_some(edges.covered_median_m);
  (*json)["edge_covered_p95_m"] = of_some(edges.covered_p95_m);
  (*json)["edge_bias_m"] = of_some(edges.bias_m);
  (*json)["edge_missed_pct"] = of_some(100.0 * edges.missed_share);
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
  EdgeJson(map.edges, &json);
  json["over_segmentation"] = map.over_segmentation;
  json["under_segmentation"] = map.under_segmentation;
  json["confusion_m2"] = map.confusion_m2;
  json["polygons"] = Json::array();
  for (const PolygonEvaluation& polygon : map.polygons) json["polygons"].push_back(PolygonJson(polygon));
  return json;
}

Json FeetJson(const FeetEvaluation& feet) {
  Json json;
  json["unsupported_pct"] = OrNull(feet.unsupported_pct());
  json["offered_pct"] = OrNull(feet.offered_pct());
  json["tread_offered_pct"] = OrNull(feet.tread_offered_pct());
  json["tread_offered_min_pct"] = OrNull(feet.tread_offered_min_pct());
  json["drop_over_p100_m"] = OrNull(feet.drop_over_p100_m);
  EdgeJson(feet.edges, &json);
  json["foothold_m2"] = feet.foothold_m2;
  json["unsupported_tread_m2"] = feet.unsupported_tread_m2;
  json["unsupported_drop_m2"] = feet.unsupported_drop_m2;
  json["well_seen_m2"] = feet.well_seen_m2;
  json["num_drop_samples"] = feet.drops.size();
  json["treads"] = Json::array();
  for (const TreadFeet& tread : feet.treads) {
    json["treads"].push_back({{"id", tread.id},
                              {"name", tread.name},
                              {"well_seen_m2", tread.well_seen_m2},
                              {"offered_pct", tread.offered_pct()}});
  }
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

Json ConsistencyJson(const DisparityConsistency& consistency) {
  const auto of_some = [](std::int64_t count, double value) {
    return count > 0 ? Json(value) : Json(nullptr);
  };
  Json json;
  json["num_images"] = consistency.num_images;
  json["density_pct"] = consistency.density_pct;
  json["photometric_median"] = of_some(consistency.num_photometric, consistency.photometric_median);
  json["photometric_p90"] = of_some(consistency.num_photometric, consistency.photometric_p90);
  json["temporal_median_px"] = of_some(consistency.num_temporal, consistency.temporal_median_px);
  json["temporal_off_pct"] = of_some(consistency.num_temporal, consistency.temporal_off_pct);
  return json;
}

Json RegionsJson(const RegionCensus& regions) {
  return {{"count", regions.count},
          {"area_m2", regions.area_m2},
          {"sliver_pct", regions.sliver_pct()},
          {"unknown_pct", regions.unknown_pct()}};
}

Json TimeJson(const Evaluation& evaluation) {
  const ReplayStats& stats = evaluation.stats;
  Json json;
  json["frames"] = stats.frames;
  json["tracked"] = stats.tracked;
  json["bridged"] =
      std::count_if(evaluation.frames.begin(), evaluation.frames.end(),
                    [](const ResultFrame& frame) { return frame.status == TrackingStatus::kBridging; });
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
  if (evaluation.feet) json["feet"] = FeetJson(*evaluation.feet);
  if (evaluation.staircases) json["staircases"] = StaircasesJson(*evaluation.staircases);
  if (evaluation.disparity) json["disparity"] = DisparityJson(*evaluation.disparity);
  if (evaluation.consistency) json["consistency"] = ConsistencyJson(*evaluation.consistency);
  json["regions"] = RegionsJson(evaluation.regions);
  json["time"] = TimeJson(evaluation);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ToJson(const DisparityErrors& errors) { return ErrorsJson(errors).dump() + "\n"; }

}  // namespace terrace
