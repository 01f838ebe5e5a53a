// SPDX-License-Identifier: BSD-3-Clause
#include "results/explanations_file.h"

#include <utility>
#include <vector>

#include "core/angles.h"
#include "results/json_text.h"
#include "results/text_lines.h"

namespace terrace {
namespace {

template <typename Enum>
OrderedJson NameOrNull(const std::optional<Enum>& value) {
  return value ? OrderedJson(Name(*value)) : OrderedJson(nullptr);
}

OrderedJson ExplainedRegionJson(const RegionExplanation& r) {
  OrderedJson neighbors = OrderedJson::array();
  for (const NeighborRegion& n : r.neighbors)
    neighbors.push_back({{"id", n.id}, {"joins", n.joins}, {"step_m", n.step_m}});
  return {{"id", r.id},
          {"label", Name(r.label)},
          {"confidence", r.confidence},
          {"rule", Name(r.rule)},
          {"slope_deg", Degrees(r.slope_rad)},
          {"slope_sigma_deg", Degrees(r.slope_sigma_rad)},
          {"offset_sigma_m", r.offset_sigma_m},
          {"rms_m", r.rms_m},
          {"noise_m", r.noise_m},
          {"area_m2", r.area_m2},
          {"observations", r.num_observations},
          {"largest_square_m", OrNullJson(r.largest_square_m)},
          {"nearest_view_m", OrNullJson(r.nearest_view_m)},
          {"lowest_step_m", OrNullJson(r.lowest_step_m)},
          {"height_m", OrNullJson(r.height_m)},
          {"large", OrNullJson(r.large)},
          {"reachable", OrNullJson(r.reachable)},
          {"decided_by", OrNullJson(r.decided_by)},
          {"staircase", OrNullJson(r.staircase)},
          {"step_index", OrNullJson(r.step_index)},
          {"by_itself", NameOrNull(r.by_itself)},
          {"next_label", NameOrNull(r.next_label)},
          {"next_frames", r.num_next},
          {"neighbors", std::move(neighbors)},
          {"text", r.text}};
}

OrderedJson ExplainedStaircaseJson(const StaircaseExplanation& s) {
  return {{"id", s.id},
          {"confidence", s.confidence},
          {"num_steps", s.num_risers},
          {"num_treads", s.num_treads},
          {"riser_m", s.riser_m},
          {"riser_sigma_m", s.riser_sigma_m},
          {"tread_m", s.tread_m},
          {"tread_sigma_m", s.tread_sigma_m},
          {"pitch_deg", Degrees(s.pitch_rad)},
          {"risers_seen", s.risers_seen},
          {"treads_seen", s.treads_seen},
          {"foot_region", OrNullJson(s.foot_region)},
          {"head_region", OrNullJson(s.head_region)},
          {"steps_seen", s.num_seen},
          {"steps_to_see", s.num_to_see},
          {"seen_sharply", s.seen_sharply},
          {"faces_tile", s.faces_tile},
          {"sides_agree", s.sides_agree},
          {"height_rms_m", s.height_rms_m},
          {"text", s.text}};
}

/// The value of a member that may be null.
template <typename T>
std::optional<T> OrNull(const JsonValue& json, T (JsonValue::*read)() const) {
  return json.IsNull() ? std::nullopt : std::optional<T>((json.*read)());
}

int IntegerIn(const JsonValue& json) { return static_cast<int>(json.Integer()); }

TerrainLabel LabelIn(const JsonValue& json) {
  const std::optional<TerrainLabel> label = TerrainLabelFromName(json.Text());
  if (!label) json.Fail("must be a label");
  return *label;
}

std::vector<int> StepsIn(const JsonValue& json) {
  std::vector<int> steps;
  for (const JsonValue& item : json.Items()) steps.push_back(IntegerIn(item));
  return steps;
}

RegionExplanation RegionIn(const JsonValue& json) {
  RegionExplanation r;
  r.id = json["id"].Integer();
  r.label = LabelIn(json["label"]);
  r.confidence = json["confidence"].Number();
  const std::optional<LabelRule> rule = LabelRuleFromName(json["rule"].Text());
  if (!rule) json["rule"].Fail("must be a rule of the labels");
  r.rule = *rule;
  r.slope_rad = Radians(json["slope_deg"].Number());
  r.slope_sigma_rad = Radians(json["slope_sigma_deg"].Number());
  r.offset_sigma_m = json["offset_sigma_m"].Number();
  r.rms_m = json["rms_m"].Number();
  r.noise_m = json["noise_m"].Number();
  r.area_m2 = json["area_m2"].Number();
  r.num_observations = IntegerIn(json["observations"]);
  r.largest_square_m = NumberOrNull(json["largest_square_m"]);
  r.nearest_view_m = NumberOrNull(json["nearest_view_m"]);
  r.lowest_step_m = NumberOrNull(json["lowest_step_m"]);
  r.height_m = NumberOrNull(json["height_m"]);
  r.large = OrNull(json["large"], &JsonValue::Bool);
  r.reachable = OrNull(json["reachable"], &JsonValue::Bool);
  r.decided_by = OrNull(json["decided_by"], &JsonValue::Integer);
  r.staircase = OrNull(json["staircase"], &JsonValue::Integer);
  if (!json["step_index"].IsNull()) r.step_index = IntegerIn(json["step_index"]);
  if (!json["by_itself"].IsNull()) r.by_itself = LabelIn(json["by_itself"]);
  if (!json["next_label"].IsNull()) r.next_label = LabelIn(json["next_label"]);
  r.num_next = IntegerIn(json["next_frames"]);
  for (const JsonValue& item : json["neighbors"].Items())
    r.neighbors.push_back({item["id"].Integer(), item["joins"].Bool(), item["step_m"].Number()});
  r.text = json["text"].Text();
  return r;
}

StaircaseExplanation StaircaseIn(const JsonValue& json) {
  StaircaseExplanation s;
  s.id = json["id"].Integer();
  s.confidence = json["confidence"].Number();
  s.num_risers = IntegerIn(json["num_steps"]);
  s.num_treads = IntegerIn(json["num_treads"]);
  s.riser_m = json["riser_m"].Number();
  s.riser_sigma_m = json["riser_sigma_m"].Number();
  s.tread_m = json["tread_m"].Number();
  s.tread_sigma_m = json["tread_sigma_m"].Number();
  s.pitch_rad = Radians(json["pitch_deg"].Number());
  s.risers_seen = StepsIn(json["risers_seen"]);
  s.treads_seen = StepsIn(json["treads_seen"]);
  s.foot_region = OrNull(json["foot_region"], &JsonValue::Integer);
  s.head_region = OrNull(json["head_region"], &JsonValue::Integer);
  s.num_seen = IntegerIn(json["steps_seen"]);
  s.num_to_see = IntegerIn(json["steps_to_see"]);
  s.seen_sharply = json["seen_sharply"].Bool();
  s.faces_tile = json["faces_tile"].Bool();
  s.sides_agree = json["sides_agree"].Bool();
  s.height_rms_m = json["height_rms_m"].Number();
  s.text = json["text"].Text();
  return s;
}

}  // namespace

std::string ExplanationsText(const Explanations& explanations) {
  std::string text;
  for (const RegionExplanation& region : explanations.regions)
    text += Dumped({{"region", ExplainedRegionJson(region)}}) + '\n';
  for (const StaircaseExplanation& staircase : explanations.staircases)
    text += Dumped({{"staircase", ExplainedStaircaseJson(staircase)}}) + '\n';
  return text;
}

Explanations ReadExplanationsFile(const std::filesystem::path& path) {
  Explanations explanations;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    if (json.Has("region"))
      explanations.regions.push_back(RegionIn(json["region"]));
    else
      explanations.staircases.push_back(StaircaseIn(json["staircase"]));
  });
  return explanations;
}

}  // namespace terrace
