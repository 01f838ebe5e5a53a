// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/report.h"

#include <cstdio>

#include "core/print.h"
#include "core/time.h"
#include "evaluation/disparity_picture.h"
#include "evaluation/film_strip.h"
#include "evaluation/report_parts.h"
#include "evaluation/svg_plot.h"

namespace terrace {
namespace {

constexpr const char* kStyleSheet = R"(
body { font: 15px/1.45 system-ui, sans-serif; color: #1d2129; max-width: 1340px; margin: 24px auto; padding: 0 20px; }
h1 { font-size: 24px; margin: 0 0 2px; } h2 { font-size: 18px; margin: 30px 0 10px; border-bottom: 1px solid #d5d9e0; }
p.source { color: #5c6370; margin: 0 0 14px; overflow-wrap: anywhere; }
.tiles { display: flex; flex-wrap: wrap; gap: 10px; }
.tile { border: 1px solid #d5d9e0; border-radius: 6px; padding: 8px 14px; min-width: 116px; }
.tile b { display: block; font-size: 20px; } .tile span { color: #5c6370; font-size: 13px; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(460px, 1fr)); gap: 14px; align-items: start; }
svg { width: 100%; height: auto; background: #fbfbfc; border: 1px solid #e4e7ec; border-radius: 6px; }
svg text { font: 12px system-ui, sans-serif; fill: #3b4250; } svg text.title { font-size: 14px; font-weight: 600; }
.grid { stroke: #e1e4ea; } .reference { stroke: #b04a4a; stroke-dasharray: 5 4; } .bar { fill: #6ea8de; }
.mark { stroke: #b04a4a; stroke-width: 2; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 6px 0 14px; }
th, td { padding: 3px 10px; text-align: right; border-bottom: 1px solid #e4e7ec; } th { font-weight: 600; }
th:first-child, td:first-child, td.text, th.text { text-align: left; }
figure { margin: 10px 0; } figcaption { color: #5c6370; margin-bottom: 4px; } img { width: 100%; height: auto; }
.scroll { overflow-x: auto; max-height: 520px; overflow-y: auto; }
.film { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 14px; }
.film figure { margin: 0; } .keyframe { fill: none; stroke: #0b6bcb; stroke-width: 4; }
.swatch { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin: 0 4px 0 12px; vertical-align: -1px; }
)";

void Tile(std::string* html, const std::string& value, const char* name) {
  *html += "<div class=\"tile\"><b>" + value + "</b><span>" + name + "</span></div>\n";
}

void AddTiles(const Evaluation& evaluation, std::string* html) {
  *html += "<div class=\"tiles\">\n";
  if (evaluation.trajectory && evaluation.trajectory->num_matched > 0) {
    const TrajectoryEvaluation& trajectory = *evaluation.trajectory;
    Tile(html, Number("%.1f mm", 1e3 * trajectory.ate_rmse_m), "ATE rms");
    if (trajectory.Segment(1.0))
      Tile(html, Number("%.2f %%", trajectory.Segment(1.0)->translation_pct), "over 1 m");
    Tile(html, Number("%.1f %%", 100 * trajectory.coverage), "poses of the truth");
    if (trajectory.covariance.count > 0)
      Tile(html, Number("%.1f", trajectory.covariance.mean_nees), "NEES (6)");
  }
  if (evaluation.map) {
    Tile(html, Number("%.1f %%", 100 * evaluation.map->coverage), "map coverage");
    Tile(html, Number("%.1f %%", 100 * evaluation.map->ghost_area), "ghost area");
    Tile(html, Number("%.1f mm", 1e3 * evaluation.map->support_plane_rms_m), "support planes rms");
    Tile(html, Number("%.3f", evaluation.map->mean_iou()), "mean IoU");
  }
  if (evaluation.feet) {
    const FeetEvaluation& feet = *evaluation.feet;
    if (feet.unsupported_pct()) Tile(html, Number("%.2f %%", *feet.unsupported_pct()), "unsupported");
    if (feet.offered_pct()) Tile(html, Number("%.1f %%", *feet.offered_pct()), "offered");
  }
  if (evaluation.staircases) {
    Tile(html,
         std::to_string(evaluation.staircases->num_found) + " of " +
             std::to_string(evaluation.staircases->num_true),
         "staircases");
  }
  Tile(html, Number("%.1f /s", evaluation.stats.rate_hz), "frames");
  Tile(html, Number("%.0f MiB", evaluation.stats.peak_rss_mib), "memory at most");
  *html += "</div>\n";
}

std::string PlotPath(const TrajectoryEvaluation& trajectory, View view, const char* title) {
  PlotSeries truth{"truth", kTruthColour, {}}, result{"result", kResultColour, {}};
  for (const TrajectorySample& sample : trajectory.samples) {
    truth.points.push_back(view(sample.p_true));
    result.points.push_back(view(sample.p_aligned));
  }
  PlotStyle style;
  style.title = title;
  style.x_label = "x [m]";
  style.y_label = view.up == 1 ? "y [m]" : "z [m]";
  style.equal_axes = true;
  return PlotLines(style, {truth, result});
}

void AddTrajectory(const TrajectoryEvaluation& trajectory, std::string* html) {
  *html += "<h2>Trajectory</h2>\n<div class=\"plots\">\n";
  *html += PlotPath(trajectory, kFromAbove, "Path from above") +
           PlotPath(trajectory, kFromTheSide, "Path from the side");
  PlotSeries aligned{"aligned by positions", kResultColour, {}},
      first{"by the first pose", kSecondColour, {}};
  PlotSeries rotation{"", kSecondColour, {}}, nees{"", kResultColour, {}};
  for (const TrajectorySample& sample : trajectory.samples) {
    const double t_s = Seconds(sample.t - trajectory.samples.front().t);
    aligned.points.emplace_back(t_s, 1e3 * sample.error_m);
    first.points.emplace_back(t_s, 1e3 * sample.error_from_first_m);
    rotation.points.emplace_back(t_s, sample.rotation_from_first_deg);
    if (sample.nees) nees.points.emplace_back(t_s, *sample.nees);
  }
  PlotStyle style;
  style.title = "Position error";
  style.x_label = "time [s]";
  style.y_label = "mm";
  style.y_from_zero = true;
  *html += PlotLines(style, {aligned, first});
  style.title = "Rotation error since the first pose";
  style.y_label = "deg";
  *html += PlotLines(style, {rotation});
  if (!nees.points.empty()) {
    style.title = "Normalised error squared of the pose";
    style.y_label = "NEES";
    style.y_from_zero = false;
    style.logarithmic_y = true;
    style.references = {{6.0, "6: honest"}, {12.592, "95 %"}};
    *html += PlotLines(style, {nees});
  }
  *html += "</div>\n<table><tr><th>piece</th><th>starts</th><th>%</th><th>deg/m</th></tr>\n";
  for (const SegmentError& segment : trajectory.segments) {
    Print(html, "<tr><td>%g m</td><td>%d</td><td>%.3f</td><td>%.4f</td></tr>\n", segment.length_m,
          segment.count, segment.translation_pct, segment.rotation_deg_per_m);
  }
  Print(html, "<tr><td>mean of all</td><td>%d</td><td>%.3f</td><td>%.4f</td></tr></table>\n",
        trajectory.mean_of_all.count, trajectory.mean_of_all.translation_pct,
        trajectory.mean_of_all.rotation_deg_per_m);
}

void AddDisparity(const DisparityEvaluation& disparity, std::string* html) {
  const DisparityErrors& errors = disparity.errors;
  Print(html,
        "<h2>Disparity</h2>\n<p>%d images. Density %.2f %%, invented %.1f %% of the hidden pixels; average "
        "error "
        "%.3f px, rms %.3f px; lock %.4f px, bias %+.4f px.</p>\n",
        disparity.num_images, errors.density_pct(), errors.invented_pct(), errors.average_px(),
        errors.rms_px(), errors.lock_px(), errors.bias_px());
  *html += "<table><tr><th></th><th>bad-0.5 %</th><th>bad-1 %</th><th>bad-2 %</th><th>D1 %</th></tr>\n";
  Print(html, "<tr><td>of all</td><td>%.2f</td><td>%.2f</td><td>%.2f</td><td>%.2f</td></tr>\n",
        errors.bad_all_pct(0.5), errors.bad_all_pct(1.0), errors.bad_all_pct(2.0), errors.d1_all_pct());
  Print(html, "<tr><td>of valid</td><td>%.2f</td><td>%.2f</td><td>%.2f</td><td>%.2f</td></tr></table>\n",
        errors.bad_valid_pct(0.5), errors.bad_valid_pct(1.0), errors.bad_valid_pct(2.0),
        errors.d1_valid_pct());
  const PlaneFigures planes = disparity.Planes({}, 1e9);
  Print(
      html,
      "<p>%d planes: offset %.3f px, %.2f mm, angle %.2f deg (medians). Edges: %.2f px median of %zu.</p>\n",
      planes.count, planes.offset_px, planes.offset_mm, planes.angle_deg, disparity.edge_median_px(),
      disparity.edges.size());
  const auto show = [&](const char* which, const std::optional<DisparityExample>& example) {
    if (!example) return;
    Print(html,
          "<figure><figcaption>The %s image, %lld: bad-1 %.2f %% of all. Disparity, and error: grey up to 2 "
          "px, "
          "white beyond or missing.</figcaption>\n",
          which, static_cast<long long>(example->t_capture.ns), example->bad1_all_pct);
    *html += EmbeddedImage(example->picture, std::string("disparity and error of the ") + which + " image") +
             "</figure>\n";
  };
  show("best", disparity.best);
  show("worst", disparity.worst);
}

/// What was said about the pose of a frame, unless all was well.
std::string TroubleAt(Timestamp t_capture, const std::vector<ResultFrame>& frames) {
  for (const ResultFrame& frame : frames) {
    if (frame.t_capture != t_capture) continue;
    if (frame.status == TrackingStatus::kTracking && frame.reason.empty()) return "";
    return std::string("; ") + Name(frame.status) + (frame.reason.empty() ? "" : ": ") +
           EscapeMarkup(frame.reason);
  }
  return "";
}

void AddFilm(const Evaluation& evaluation, std::string* html) {
  *html += "<h2>Tracked landmarks</h2>\n";
  if (evaluation.film.empty()) {
    *html +=
        "<p>No film strip: <code>terraced replay ... --save-tracks 8</code> keeps what it is made of.</p>\n";
    return;
  }
  const auto swatch = [html](const std::string& colour, const char* text) {
    *html += "<span class=\"swatch\" style=\"background: " + colour + "\"></span>" + text;
  };
  *html += "<p>";
  swatch(ColourOf(LandmarkFate::kAgrees), "found, agrees with the pose");
  swatch(ColourOf(LandmarkFate::kRejected), "found, rejected");
  swatch(ColourOf(LandmarkFate::kCreated), "new in this keyframe");
  *html +=
      "; lines: where they were in the frames before, dots on them: in keyframes; a blue frame: a "
      "keyframe</p>\n<div class=\"film\">\n";
  for (const FilmPicture& picture : evaluation.film) {
    const double t_s =
        evaluation.frames.empty() ? 0.0 : Seconds(picture.t_capture - evaluation.frames.front().t_capture);
    Print(html, "<figure><figcaption>frame %lld, %.2f s%s: %d agree, %d rejected",
          static_cast<long long>(picture.frame), t_s, picture.is_keyframe ? ", keyframe" : "",
          picture.Count(LandmarkFate::kAgrees), picture.Count(LandmarkFate::kRejected));
    if (picture.is_keyframe) Print(html, ", %d new", picture.Count(LandmarkFate::kCreated));
    *html += TroubleAt(picture.t_capture, evaluation.frames) + "</figcaption>\n" + DrawPicture(picture) +
             "</figure>\n";
  }
  *html += "</div>\n";
}

void AddTime(const Evaluation& evaluation, std::string* html) {
  const ReplayStats& stats = evaluation.stats;
  Print(html,
        "<h2>Time and memory</h2>\n<p>%lld frames, %lld tracked, %lld dropped, %.2f frames/s, %.0f MiB at "
        "most, map "
        "of %lld cells and %zu regions in %.1f MiB.</p>\n",
        static_cast<long long>(stats.frames), static_cast<long long>(stats.tracked),
        static_cast<long long>(stats.dropped), stats.rate_hz, stats.peak_rss_mib,
        static_cast<long long>(stats.map_cells), evaluation.result_map.regions.size(),
        static_cast<double>(stats.map_bytes) / (1 << 20));
  *html += "<div class=\"plots\">\n";
  std::vector<PlotBar> bars;
  for (const auto& [name, stage] : stats.StagesInOrder())
    bars.push_back({name, stage.cpu_ms_mean, stage.p99_ms});
  PlotStyle style;
  style.title = "CPU time a frame, mean | wall time, 99 % [ms]";
  if (!bars.empty()) *html += PlotBars(style, bars);
  PlotSeries cells{"", kResultColour, {}}, latency{"", kSecondColour, {}};
  for (const ResultFrame& frame : evaluation.frames) {
    const double t_s = Seconds(frame.t_capture - evaluation.frames.front().t_capture);
    cells.points.emplace_back(t_s, 1e-3 * static_cast<double>(frame.map_cells));
    if (frame.latency_ms) latency.points.emplace_back(t_s, *frame.latency_ms);
  }
  style.x_label = "time [s]";
  style.y_from_zero = true;
  style.title = "Map cells [thousand]";
  style.y_label = "thousand";
  if (!cells.points.empty()) *html += PlotLines(style, {cells});
  style.title = "Camera to map";
  style.y_label = "ms";
  if (!latency.points.empty()) *html += PlotLines(style, {latency});
  *html += "</div>\n";
  if (evaluation.latency_growth) {
    Print(html, "<p>Latency grows by %+.3f ms per 1000 cells, %+.2f ms per 100 regions.</p>\n",
          evaluation.latency_growth->ms_per_1000_cells, evaluation.latency_growth->ms_per_100_regions);
  }
}

}  // namespace

std::string ToReport(const Evaluation& evaluation, const std::string& view) {
  const std::string name = EscapeMarkup(std::filesystem::absolute(evaluation.sequence).filename().string());
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>Terrace: " +
      name + "</title><style>" + kStyleSheet + "</style></head><body>\n<h1>" + name +
      "</h1>\n<p class=\"source\">" + EscapeMarkup(evaluation.result.string()) + " against " +
      EscapeMarkup(evaluation.sequence.string()) + "</p>\n";
  if (!view.empty()) {
    html +=
        "<p><a href=\"" + EscapeMarkup(view) + "\">Look around</a> in the map, with the truth over it.</p>\n";
  }
  AddTiles(evaluation, &html);
  for (const std::string& note : evaluation.notes) html += "<p>Note: " + EscapeMarkup(note) + "</p>\n";
  if (evaluation.trajectory && !evaluation.trajectory->samples.empty())
    AddTrajectory(*evaluation.trajectory, &html);
  AddFilm(evaluation, &html);
  if (evaluation.map) AddMapReport(evaluation, &html);
  if (evaluation.feet) AddFeetReport(*evaluation.feet, &html);
  if (evaluation.staircases) AddStaircasesReport(*evaluation.staircases, &html);
  if (evaluation.disparity) AddDisparity(*evaluation.disparity, &html);
  AddTime(evaluation, &html);
  return html + "</body></html>\n";
}

}  // namespace terrace
