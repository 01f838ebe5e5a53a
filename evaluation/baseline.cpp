// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/baseline.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/json_value.h"

namespace terrace {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "terrace-baseline";

/// The value at "a.b.c"; none when it is absent, null or no number.
std::optional<double> NumberAt(const nlohmann::json& document, const std::string& path) {
  const nlohmann::json* at = &document;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const auto member = at->is_object() ? at->find(path.substr(begin, end - begin)) : at->end();
    if (!at->is_object() || member == at->end()) return std::nullopt;
    at = &*member;
    begin = end + 1;
  }
  if (!at->is_number()) return std::nullopt;
  return at->get<double>();
}

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof(text),
                std::abs(value) < 0.1   ? "%.4f"
                : std::abs(value) < 100 ? "%.3f"
                                        : "%.0f",
                value);
  return text;
}

std::string WithDifference(double value, std::optional<double> stored) {
  if (!stored) return Short(value);
  const double difference = value - *stored;
  const std::string text = Short(difference);
  if (std::strtod(text.c_str(), nullptr) == 0.0) return Short(value) + " (=)";
  return Short(value) + " (" + (difference > 0 ? "+" : "") + text + ")";
}

bool Worse(double value, double stored, const Tolerance& tolerance) {
  if (!tolerance.judged()) return false;
  const double by = tolerance.lower_is_better ? value - stored : stored - value;
  return by > std::max(tolerance.absolute, tolerance.relative * std::abs(stored));
}

/// "trajectory.ate_rmse_m" as "ate_rmse_m", as long as no other figure ends so.
std::string ColumnName(const std::string& path, const std::vector<BaselineFigure>& figures) {
  const auto last = [](const std::string& name) { return name.substr(name.rfind('.') + 1); };
  const auto same = std::count_if(figures.begin(), figures.end(), [&](const BaselineFigure& other) {
    return last(other.path) == last(path);
  });
  return same > 1 ? path : last(path);
}

std::string Aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += row[i];
      if (i + 1 < row.size()) text.append(widths[i] - row[i].size() + 2, ' ');
    }
    text += '\n';
  }
  return text;
}

}  // namespace

std::vector<BaselineFigure> DefaultFigures() {
  constexpr bool kLower = true, kHigher = false;
  return {{"trajectory.ate_rmse_m", {kLower, 0.002, 0.15}},
          {"trajectory.coverage", {kHigher, 0.002, 0.0}},
          {"trajectory.rpe1m_pct", {kLower, 0.05, 0.1}},
          {"map.coverage", {kHigher, 0.01, 0.0}},
          {"map.ghost_area", {kLower, 0.005, 0.1}},
          {"map.support_plane_rms_m", {kLower, 0.001, 0.15}},
          {"map.mean_iou", {kHigher, 0.02, 0.0}},
          {"staircases.recall", {kHigher, 0.001, 0.0}},
          {"staircases.precision", {kHigher, 0.001, 0.0}},
          {"disparity.bad1_all_pct", {kLower, 0.2, 0.1}},
          {"disparity.lock_px", {kLower, 0.005, 0.2}},
          // Of a shared machine; to look at.
          {"time.rate_hz", {kHigher, 0.0, 0.0}},
          {"time.peak_rss_mib", {kLower, 20.0, 0.15}}};
}

Figures FiguresOf(const std::string& evaluation_json, const std::string& where,
                  const std::vector<BaselineFigure>& figures) {
  const nlohmann::json document = ParseJson(evaluation_json, where);
  Figures found;
  for (const BaselineFigure& figure : figures) {
    if (const std::optional<double> value = NumberAt(document, figure.path)) found[figure.path] = *value;
  }
  return found;
}

Baseline ParseBaseline(const std::string& text, const std::string& where) {
  // In the order of the file, which is that of the columns.
  const nlohmann::json document = ParseJson(text, where);
  const JsonValue json(document, where);
  if (json["format"].Text() != kFormat) json["format"].Fail(std::string("must be ") + kFormat);
  Baseline baseline;
  for (const JsonValue& item : json["figures"].Items()) {
    const std::string better = item["better"].Text();
    if (better != "lower" && better != "higher") item["better"].Fail("must be lower or higher");
    baseline.figures.push_back(
        {item["path"].Text(), {better == "lower", item["absolute"].Number(), item["relative"].Number()}});
  }
  for (const auto& [name, sequence] : json["sequences"].Members()) {
    for (const auto& [path, value] : sequence.Members()) baseline.sequences[name][path] = value.Number();
  }
  return baseline;
}

std::string ToJson(const Baseline& baseline) {
  Json json;
  json["format"] = kFormat;
  json["figures"] = Json::array();
  for (const BaselineFigure& figure : baseline.figures) {
    Json one;
    one["path"] = figure.path;
    one["better"] = figure.tolerance.lower_is_better ? "lower" : "higher";
    one["absolute"] = figure.tolerance.absolute;
    one["relative"] = figure.tolerance.relative;
    json["figures"].push_back(one);
  }
  json["sequences"] = Json::object();
  for (const auto& [name, figures] : baseline.sequences) json["sequences"][name] = figures;
  return json.dump(1) + "\n";
}

BaselineComparison Compare(const Baseline& baseline, const std::map<std::string, Figures>& measured,
                           const std::vector<std::string>& failed) {
  BaselineComparison comparison;
  std::vector<std::vector<std::string>> rows;
  rows.push_back({"sequence"});
  for (const BaselineFigure& figure : baseline.figures) {
    rows[0].push_back(ColumnName(figure.path, baseline.figures));
  }
  for (const auto& [name, figures] : measured) {
    const auto stored_figures = baseline.sequences.find(name);
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(name);
    for (const BaselineFigure& figure : baseline.figures) {
      std::optional<double> stored;
      if (stored_figures != baseline.sequences.end()) {
        const auto it = stored_figures->second.find(figure.path);
        if (it != stored_figures->second.end()) stored = it->second;
      }
      const auto value = figures.find(figure.path);
      if (value == figures.end()) {
        row.push_back("-");
        if (stored && figure.tolerance.judged()) {
          row.back() = "gone!";
          comparison.worse.push_back(name + ": " + figure.path + " was " + Short(*stored) +
                                     " and is no longer measured");
        }
        continue;
      }
      row.push_back(WithDifference(value->second, stored));
      if (stored && Worse(value->second, *stored, figure.tolerance)) {
        row.back() += "!";
        comparison.worse.push_back(name + ": " + figure.path + " was " + Short(*stored) + " and is " +
                                   Short(value->second));
      }
    }
  }
  for (const std::string& name : failed) {
    rows.push_back({name, "failed!"});
    comparison.worse.push_back(name + ": failed");
  }
  comparison.table = Aligned(rows);
  return comparison;
}

}  // namespace terrace
