// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/print.h"
#include "evaluation/disparity_picture.h"
#include "evaluation/feet_picture.h"
#include "evaluation/planar_shape.h"
#include "evaluation/report_parts.h"
#include "evaluation/svg_plot.h"

namespace terrace {
namespace {

const char* LabelColour(const std::string& label) {
  if (label == "walkway") return "#58a65c";
  if (label == "ramp") return "#c9b037";
  if (label == "stair_tread") return "#4aa3df";
  if (label == "stair_riser") return "#26619c";
  if (label == "wall") return "#9b8579";
  if (label == "obstacle") return "#d0524a";
  if (label == "level") return "#e59a4a";
  return "#b9bdc6";
}

std::string PlotPlan(const Evaluation& evaluation, View view, const char* title) {
  std::vector<PlotShape> shapes;
  const auto add = [&](const Ring& outline, const std::vector<Ring>& holes, const std::string& fill,
                       const std::string& stroke, const std::string& tooltip) {
    PlotShape shape{{}, fill, stroke, tooltip};
    std::vector<Ring> rings{outline};
    rings.insert(rings.end(), holes.begin(), holes.end());
    for (const Ring& ring : rings) {
      auto& flat = shape.rings.emplace_back();
      for (const Eigen::Vector3d& p : ring) flat.push_back(view(p));
    }
    shapes.push_back(std::move(shape));
  };
  for (const auto& region : evaluation.result_map.regions) {
    std::vector<Ring> holes;
    for (const Ring& hole : region->holes_world) holes.push_back(Moved(evaluation.map->T_true_result, hole));
    const std::string label = Name(region->label);
    add(Moved(evaluation.map->T_true_result, region->outline_world), holes,
        std::string(LabelColour(label)) + "aa", LabelColour(label),
        "region " + std::to_string(region->id) + ": " + label);
  }
  // Only what was asked for: ceilings would hide everything below.
  for (const PolygonEvaluation& asked : evaluation.map->polygons) {
    for (const TruePolygon& polygon : evaluation.scene.polygons) {
      if (polygon.id != asked.id) continue;
      add(polygon.outline_world, polygon.holes_world, "none", "#1d2129", polygon.name + ": " + polygon.label);
    }
  }
  PlotSeries path{"camera", kSecondColour, {}};
  if (evaluation.trajectory) {
    for (const TrajectorySample& sample : evaluation.trajectory->samples)
      path.points.push_back(view(sample.p_true));
  }
  PlotStyle style;
  style.title = title;
  style.x_label = "x [m]";
  style.y_label = view.up == 1 ? "y [m]" : "z [m]";
  return PlotShapes(style, shapes, {path});
}

void AddConfusion(const MapEvaluation& map, std::string* html) {
  std::vector<std::string> columns;
  for (const auto& [row, cells] : map.confusion_m2) {
    for (const auto& [column, area] : cells) {
      if (std::find(columns.begin(), columns.end(), column) == columns.end()) columns.push_back(column);
    }
  }
  std::sort(columns.begin(), columns.end());
  *html += "<h3>Confusion: true label down, label of the result across [m²]</h3>\n<table><tr><th></th>";
  for (const std::string& column : columns) *html += "<th>" + EscapeMarkup(column) + "</th>";
  *html += "</tr>\n";
  for (const auto& [row, cells] : map.confusion_m2) {
    double sum = 0.0;
    for (const auto& [column, area] : cells) sum += area;
    *html += "<tr><td>" + EscapeMarkup(row) + "</td>";
    for (const std::string& column : columns) {
      const auto cell = cells.find(column);
      if (cell == cells.end()) {
        *html += "<td></td>";
        continue;
      }
      const char* colour = column == row ? "88, 166, 92" : "208, 82, 74";
      Print(html, "<td style=\"background: rgba(%s, %.2f)\">%.2f</td>", colour, 0.75 * cell->second / sum,
            cell->second);
    }
    *html += "</tr>\n";
  }
  *html += "</table>\n";
}

void AddPolygons(const MapEvaluation& map, std::string* html) {
  std::vector<PolygonEvaluation> polygons = map.polygons;
  std::stable_sort(polygons.begin(), polygons.end(),
                   [](const auto& a, const auto& b) { return a.seen_m2 > b.seen_m2; });
  *html +=
      "<h3>True polygons, largest seen area first</h3>\n<div class=\"scroll\"><table><tr><th "
      "class=\"text\">polygon</th>"
      "<th class=\"text\">label</th><th class=\"text\">found as</th><th>seen "
      "m²</th><th>covered</th><th>plane rms "
      "mm</th><th>bias mm</th><th>normal deg</th><th>edges mm</th><th>regions</th></tr>\n";
  for (const PolygonEvaluation& polygon : polygons) {
    Print(
        html,
        "<tr><td>%d %s</td><td class=\"text\">%s</td><td class=\"text\">%s</td><td>%.3f</td><td>%.1f %%</td>",
        polygon.id, EscapeMarkup(polygon.name).c_str(), EscapeMarkup(polygon.label).c_str(),
        polygon.label_found.c_str(), polygon.seen_m2, 100 * polygon.coverage());
    if (polygon.covered_m2 > 0.0) {
      Print(html, "<td>%.1f</td><td>%+.1f</td><td>%.2f</td><td>%.0f</td><td>%d</td></tr>\n",
            1e3 * polygon.plane_rms_m, 1e3 * polygon.plane_bias_m, polygon.normal_deg,
            1e3 * polygon.edges.median_m, polygon.num_regions);
    } else {
      *html += "<td></td><td></td><td></td><td></td><td></td></tr>\n";
    }
  }
  *html += "</table></div>\n";
}

std::string OrDash(const std::optional<double>& value) { return value ? Number("%.2f", *value) : "–"; }

}  // namespace

void AddMapReport(const Evaluation& evaluation, std::string* html) {
  const MapEvaluation& map = *evaluation.map;
  *html += "<h2>Map</h2>\n<p>";
  for (int k = 0; k < kNumTerrainLabels; ++k) {
    const std::string label = Name(static_cast<TerrainLabel>(k));
    *html += std::string("<span class=\"swatch\" style=\"background: ") + LabelColour(label) + "\"></span>" +
             label;
  }
  *html += "; outlines: what is true and was seen</p>\n<div class=\"plots\">\n" +
           PlotPlan(evaluation, kFromAbove, "Map from above") +
           PlotPlan(evaluation, kFromTheSide, "Map from the side") +
           "</div>\n<table><tr><th>label</th><th>IoU</th><th>true m²</th><th>right m²</th><th>false "
           "m²</th></tr>\n";
  for (const auto& [name, label] : map.labels) {
    Print(html, "<tr><td>%s</td><td>%s</td><td>%.2f</td><td>%.2f</td><td>%.2f</td></tr>\n",
          EscapeMarkup(name).c_str(), label.true_m2 > 0.0 ? Number("%.3f", label.iou()).c_str() : "",
          label.true_m2, label.correct_m2, label.false_m2);
  }
  Print(html,
        "</table>\n<p>Planes: %.1f mm rms, 95 %% within %.1f mm; normals %.2f deg. Edges: %.0f mm median, 95 "
        "%% within "
        "%.0f mm, bias %+.0f mm. %.2f regions a polygon, %.2f polygons a region.</p>\n",
        1e3 * map.plane_rms_m, 1e3 * map.plane_p95_m, map.normal_mean_deg, 1e3 * map.edges.median_m,
        1e3 * map.edges.p95_m, 1e3 * map.edges.bias_m, map.over_segmentation, map.under_segmentation);
  AddConfusion(map, html);
  AddPolygons(map, html);
}

void AddFeetReport(const FeetEvaluation& feet, std::string* html) {
  const auto percent = [](const std::optional<double>& value) {
    return value ? Number("%.2f %%", *value) : std::string("–");
  };
  *html += "<h2>Feet</h2>\n<p>Unsupported: " + percent(feet.unsupported_pct()) +
           Number(" of %.2f m² of footholds", feet.foothold_m2) +
           Number(" (%.0f cm² on treads,", 1e4 * feet.unsupported_tread_m2) +
           Number(" %.0f cm² within 10 cm of a drop). Offered: ", 1e4 * feet.unsupported_drop_m2) +
           percent(feet.offered_pct()) + Number(" of %.2f m² well seen.", feet.well_seen_m2);
  if (feet.drop_over_p100_m)
    *html += Number(" Outlines reach past drops by %.0f mm at most.", 1e3 * *feet.drop_over_p100_m);
  if (feet.edges.count > 0) {
    *html += Number(" Edges of well seen ground: %.0f mm median,", 1e3 * feet.edges.median_m) +
             Number(" 95 %% within %.0f mm,", 1e3 * feet.edges.p95_m) +
             Number(" bias %+.0f mm,", 1e3 * feet.edges.bias_m) +
             Number(" %.1f %% not covered.", 100 * feet.edges.missed_share);
  }
  *html += "</p>\n";
  if (!feet.treads.empty()) {
    *html += "<table><tr><th>tread</th><th>well seen cm²</th><th>offered</th></tr>\n";
    for (const TreadFeet& tread : feet.treads) {
      *html += "<tr><td>" + EscapeMarkup(tread.name) + "</td><td>" +
               Number("%.0f", 1e4 * tread.well_seen_m2) + "</td><td>" + percent(tread.offered_pct()) +
               "</td></tr>\n";
    }
    *html += "</table>\n";
  }
  const ColourImage picture = PictureOfFeet(feet);
  if (picture.data.empty()) return;
  *html +=
      "<figure><figcaption>From above: footholds green, those that nothing carries red, well seen ground "
      "without a foothold blue, drops black.</figcaption>\n<img style=\"width: auto; max-width: 100%; "
      "image-rendering: pixelated\" alt=\"footholds from above\" src=\"" +
      PngUri(EncodePng(picture)) + "\"></figure>\n";
}

void AddStaircasesReport(const StaircaseEvaluation& staircases, std::string* html) {
  if (staircases.matches.empty() && staircases.num_result == 0) return;
  Print(html, "<h2>Staircases</h2>\n<p>precision %.2f, recall %.2f; %d reported</p>\n", staircases.precision,
        staircases.recall, staircases.num_result);
  *html +=
      "<table><tr><th>staircase</th><th>risers</th><th>riser mm</th><th>tread mm</th><th>width "
      "mm</th><th>direction "
      "deg</th><th>first reported m</th><th>first right m</th></tr>\n";
  for (const StaircaseMatch& match : staircases.matches) {
    Print(html, "<tr><td>%d</td>", match.true_id);
    if (match.result_id) {
      Print(html, "<td>%d %+d</td><td>%+.1f</td><td>%+.1f</td><td>%+.0f</td><td>%.1f</td>",
            match.num_risers_true, match.num_risers_error, 1e3 * match.riser_error_m,
            1e3 * match.tread_error_m, 1e3 * match.width_error_m, match.direction_error_deg);
    } else {
      Print(html, "<td>%d missed</td><td></td><td></td><td></td><td></td>", match.num_risers_true);
    }
    *html +=
        "<td>" + OrDash(match.first_reported_m) + "</td><td>" + OrDash(match.first_right_m) + "</td></tr>\n";
  }
  *html += "</table>\n";
}

}  // namespace terrace
