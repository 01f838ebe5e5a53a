// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/family_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/file_bytes.h"
#include "core/print.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

using nlohmann::json;

enum class Better { kLower, kHigher, kNearZero };

/// One column: where the figure is in evaluation.json, in which unit it is shown, and what is worse.
struct FamilyColumn {
  const char* title;
  const char* pointer;
  double scale;
  Better better;
};

constexpr FamilyColumn kColumns[] = {
    {"unsup%", "/feet/unsupported_pct", 1.0, Better::kLower},
    {"offer%", "/feet/offered_pct", 1.0, Better::kHigher},
    {"tread%", "/feet/tread_offered_pct", 1.0, Better::kHigher},
    {"tr.min", "/feet/tread_offered_min_pct", 1.0, Better::kHigher},
    {"dropmm", "/feet/drop_over_p100_m", 1e3, Better::kLower},
    {"e50 mm", "/feet/edge_median_m", 1e3, Better::kLower},
    {"e95 mm", "/feet/edge_p95_m", 1e3, Better::kLower},
    {"biasmm", "/feet/edge_bias_m", 1e3, Better::kNearZero},
    {"ghost%", "/map/ghost_area", 1e2, Better::kLower},
    {"h mm", "/map/support_plane_rms_m", 1e3, Better::kLower},
    {"walkw.", "/map/iou/walkway", 1.0, Better::kHigher},
    {"tread", "/map/iou/stair_tread", 1.0, Better::kHigher},
    {"riser", "/map/iou/stair_riser", 1.0, Better::kHigher},
    {"ramp", "/map/iou/ramp", 1.0, Better::kHigher},
    {"wall", "/map/iou/wall", 1.0, Better::kHigher},
    {"obst.", "/map/iou/obstacle", 1.0, Better::kHigher},
    {"level", "/map/iou/level", 1.0, Better::kHigher},
    {"ATE mm", "/trajectory/ate_rmse_m", 1e3, Better::kLower},
};

std::optional<double> NumberAt(const json& evaluation, const std::string& pointer) {
  const json::json_pointer at(pointer);
  if (!evaluation.contains(at) || !evaluation.at(at).is_number()) return std::nullopt;
  return evaluation.at(at).get<double>();
}

/// The later of two in the order of badness.
double Worse(double a, double b, Better better) {
  if (better == Better::kNearZero) return std::abs(a) >= std::abs(b) ? a : b;
  return better == Better::kLower ? std::max(a, b) : std::min(a, b);
}

void AddFigures(const std::vector<json>& places, bool worst, std::string* text) {
  for (const FamilyColumn& column : kColumns) {
    std::vector<double> values;
    for (const json& place : places) {
      if (const auto value = NumberAt(place, column.pointer)) values.push_back(column.scale * *value);
    }
    if (values.empty()) {
      Print(text, " %6s", "-");
      continue;
    }
    double value = MeanOf(values);
    if (worst) {
      value = values.front();
      for (double other : values) value = Worse(value, other, column.better);
    }
    Print(text, std::abs(value) >= 100.0 ? " %6.0f" : " %6.2f", value);
  }
}

/// What the staircases of several places come to.
struct StairSums {
  int num_true = 0, num_result = 0, num_found = 0, num_exact = 0;
  std::vector<double> riser_mm, tread_mm;  ///< absolute errors

  void Add(const json& place) {
    const auto count = [&](const char* name) {
      return static_cast<int>(NumberAt(place, std::string("/staircases/") + name).value_or(0.0));
    };
    num_true += count("num_true");
    num_result += count("num_result");
    num_found += count("num_found");
    if (!place.contains("staircases")) return;
    for (const json& match : place.at("staircases").at("matches")) {
      if (!match.at("num_risers_error").is_number()) continue;
      num_exact += match.at("num_risers_error") == 0;
      riser_mm.push_back(1e3 * std::abs(match.at("riser_error_m").get<double>()));
      tread_mm.push_back(1e3 * std::abs(match.at("tread_error_m").get<double>()));
    }
  }
};

double Area(const json& place, const char* truth, const char* found) {
  return NumberAt(place, std::string("/map/confusion_m2/") + truth + "/" + found).value_or(0.0);
}

void AddStairs(const std::vector<json>& places, std::string* text) {
  StairSums sums;
  double stairs_as_ramp_m2 = 0.0, ramp_as_stairs_m2 = 0.0;
  for (const json& place : places) {
    sums.Add(place);
    stairs_as_ramp_m2 += Area(place, "stair_tread", "ramp") + Area(place, "stair_riser", "ramp");
    ramp_as_stairs_m2 += Area(place, "ramp", "stair_tread") + Area(place, "ramp", "stair_riser");
  }
  Print(text, "  stairs: %d of %d found, %d reported, %d with all risers", sums.num_found, sums.num_true,
        sums.num_result, sums.num_exact);
  if (!sums.riser_mm.empty()) {
    Print(text, "; riser %.1f mm (max %.0f), tread %.1f mm (max %.0f)", QuantileOf(sums.riser_mm, 0.5),
          QuantileOf(sums.riser_mm, 1.0), QuantileOf(sums.tread_mm, 0.5), QuantileOf(sums.tread_mm, 1.0));
  }
  Print(text, "; as ramp %.2f m2, ramp as stairs %.2f m2\n", stairs_as_ramp_m2, ramp_as_stairs_m2);
}

void AddRows(const std::string& name, const std::vector<json>& places, std::string* text) {
  Print(text, "%-13s%3zu mean ", name.c_str(), places.size());
  AddFigures(places, false, text);
  Print(text, "\n%-16s worst", "");
  AddFigures(places, true, text);
  *text += "\n";
  AddStairs(places, text);
}

json ParsedEvaluation(const std::string& text) {
  json evaluation = json::parse(text, nullptr, false);
  if (!evaluation.is_object() || evaluation.value("format", "") != "terrace-evaluation")
    throw FileError("family table: a text is no evaluation.json");
  return evaluation;
}

}  // namespace

std::string TableOfFamilies(const FamilyEvaluations& families) {
  std::string text;
  Print(&text, "%-22s", "family");
  for (const FamilyColumn& column : kColumns) Print(&text, " %6s", column.title);
  text += "\n";
  std::vector<json> all;
  for (const auto& [name, evaluations] : families) {
    std::vector<json> places;
    for (const std::string& evaluation : evaluations) places.push_back(ParsedEvaluation(evaluation));
    if (!places.empty()) AddRows(name, places, &text);
    all.insert(all.end(), places.begin(), places.end());
  }
  if (families.size() > 1 && !all.empty()) AddRows("all", all, &text);
  return text;
}

}  // namespace terrace
