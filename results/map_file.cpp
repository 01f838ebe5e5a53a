// SPDX-License-Identifier: BSD-3-Clause
#include "results/map_file.h"

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "results/json_text.h"
#include "results/text_lines.h"

namespace terrace {
namespace {

/// One list a ring, outline first. Of a region without edges nothing is known beyond any.
OrderedJson EdgesJson(const TerrainRegion& region) {
  OrderedJson rings = OrderedJson::array();
  std::size_t next = 0;
  const auto add = [&](const Ring& ring) {
    OrderedJson edges = OrderedJson::array();
    for (std::size_t i = 0; i < ring.size(); ++i, ++next) {
      const RegionEdge edge = next < region.edges.size() ? region.edges[next] : RegionEdge{};
      edges.push_back({{"kind", Name(edge.kind)},
                       {"step_m", OrNullJson(edge.step_m)},
                       {"sigma_m", OrNullJson(edge.sigma_m)}});
    }
    rings.push_back(std::move(edges));
  };
  add(region.outline_world);
  for (const Ring& hole : region.holes_world) add(hole);
  return rings;
}

OrderedJson RegionJson(const TerrainRegion& region) {
  OrderedJson holes = OrderedJson::array();
  for (const Ring& hole : region.holes_world) holes.push_back(RingJson(hole));
  return {{"id", region.id},
          {"revision", region.revision},
          {"label", Name(region.label)},
          {"confidence", region.confidence},
          {"normal", VectorJson(region.plane_world.normal)},
          {"offset_m", region.plane_world.offset_m},
          {"rms_m", region.rms_m},
          {"area_m2", region.area_m2},
          {"outline", RingJson(region.outline_world)},
          {"holes", holes},
          {"staircase", OrNullJson(region.staircase_id)},
          {"step_index", OrNullJson(region.step_index)},
          {"first_seen_ns", region.first_seen.ns},
          {"last_seen_ns", region.last_seen.ns},
          {"predicted", region.predicted()},
          {"why", region.why},
          {"edges", EdgesJson(region)}};
}

OrderedJson StaircaseJson(const Staircase& staircase) {
  return {{"id", staircase.id},
          {"num_steps", staircase.num_risers},
          {"num_treads", staircase.num_treads},
          {"riser_m", staircase.riser_m},
          {"riser_sigma_m", staircase.riser_sigma_m},
          {"tread_m", staircase.tread_m},
          {"tread_sigma_m", staircase.tread_sigma_m},
          {"width_m", staircase.width_m},
          {"direction_world", VectorJson(staircase.direction_up_world)},
          {"base_world", PointJson(staircase.base_world())},
          {"confidence", staircase.confidence},
          {"region_ids", staircase.region_ids}};
}

/// One list a ring, one entry a vertex.
std::vector<RegionEdge> ReadEdges(const JsonValue& json, const TerrainRegion& region) {
  std::vector<RegionEdge> edges;
  const std::vector<JsonValue> rings = json.Items();
  if (rings.size() != 1 + region.holes_world.size()) json.Fail("must have one list for each ring");
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = i == 0 ? region.outline_world : region.holes_world[i - 1];
    const std::vector<JsonValue> items = rings[i].Items();
    if (items.size() != ring.size()) rings[i].Fail("must have one entry for each vertex");
    for (const JsonValue& item : items) {
      const std::optional<EdgeKind> kind = EdgeKindFromName(item["kind"].Text());
      if (!kind) item["kind"].Fail("must be limit, drop, rise or joins");
      edges.push_back({*kind, NumberOrNull(item["step_m"]), NumberOrNull(item["sigma_m"])});
    }
  }
  return edges;
}

TerrainRegion ReadRegion(const JsonValue& json) {
  TerrainRegion region;
  region.id = json["id"].Integer();
  region.revision = static_cast<int>(json["revision"].Integer());
  const std::string label = json["label"].Text();
  const std::optional<TerrainLabel> known = TerrainLabelFromName(label);
  if (!known) json["label"].Fail("'" + label + "' is not a label");
  region.label = *known;
  region.confidence = json["confidence"].Number();
  region.plane_world = {json["normal"].UnitVector3(), json["offset_m"].Number()};
  region.rms_m = json["rms_m"].Number();
  region.area_m2 = json["area_m2"].Number();
  region.outline_world = json["outline"].Points();
  for (const JsonValue& hole : json["holes"].Items()) region.holes_world.push_back(hole.Points());
  if (!json["staircase"].IsNull()) region.staircase_id = json["staircase"].Integer();
  if (!json["step_index"].IsNull()) region.step_index = static_cast<int>(json["step_index"].Integer());
  region.first_seen.ns = json["first_seen_ns"].Integer();
  region.last_seen.ns = json["last_seen_ns"].Integer();
  for (const Eigen::Vector3d& p : region.outline_world) region.centroid_world += p;
  region.centroid_world =
      region.plane_world.Project(region.centroid_world / static_cast<double>(region.outline_world.size()));
  // Maps of older versions have none of these.
  if (json.Has("predicted") && json["predicted"].Bool()) region.source = RegionSource::kPredicted;
  if (json.Has("why")) region.why = json["why"].Text();
  if (json.Has("edges")) region.edges = ReadEdges(json["edges"], region);
  return region;
}

Staircase ReadStaircase(const JsonValue& json) {
  Staircase staircase;
  staircase.id = json["id"].Integer();
  staircase.num_risers = static_cast<int>(json["num_steps"].Integer());
  staircase.num_treads = static_cast<int>(json["num_treads"].Integer());
  staircase.riser_m = json["riser_m"].Number();
  staircase.tread_m = json["tread_m"].Number();
  staircase.width_m = json["width_m"].Number();
  if (json.Has("riser_sigma_m")) staircase.riser_sigma_m = json["riser_sigma_m"].Number();
  if (json.Has("tread_sigma_m")) staircase.tread_sigma_m = json["tread_sigma_m"].Number();
  staircase.direction_up_world = json["direction_world"].UnitVector3();
  staircase.confidence = json["confidence"].Number();
  for (const JsonValue& id : json["region_ids"].Items()) staircase.region_ids.push_back(id.Integer());
  // The file has the middle of the foot edge; the edges follow from a straight flight.
  const Eigen::Vector3d base = json["base_world"].Vector3();
  const Eigen::Vector3d half_edge =
      0.5 * staircase.width_m * Eigen::Vector3d::UnitZ().cross(staircase.direction_up_world);
  const Eigen::Vector3d head = base +
                               staircase.num_treads * staircase.tread_m * staircase.direction_up_world +
                               staircase.num_risers * staircase.riser_m * Eigen::Vector3d::UnitZ();
  staircase.foot_edge_world = {base + half_edge, base - half_edge};
  staircase.head_edge_world = {head + half_edge, head - half_edge};
  staircase.pitch_rad = std::atan2(staircase.riser_m, staircase.tread_m);
  return staircase;
}

}  // namespace

std::string TerrainMapJson(const TerrainMap& map) {
  OrderedJson regions = OrderedJson::array();
  for (const auto& region : map.regions) regions.push_back(RegionJson(*region));
  OrderedJson staircases = OrderedJson::array();
  for (const Staircase& staircase : map.staircases) staircases.push_back(StaircaseJson(staircase));
  const OrderedJson json = {
      {"format", "terrace-map"}, {"version", 1},       {"t_capture_ns", map.t_capture.ns},
      {"frame", "world"},        {"regions", regions}, {"staircases", staircases}};
  return Dumped(json) + "\n";
}

TerrainMap ReadTerrainMapFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  if (json["format"].Text() != "terrace-map") json["format"].Fail("must be terrace-map");
  if (json["version"].Integer() != 1) json["version"].Fail("only version 1 is known");
  TerrainMap map;
  map.t_capture.ns = json["t_capture_ns"].Integer();
  for (const JsonValue& item : json["regions"].Items()) {
    map.regions.push_back(std::make_shared<const TerrainRegion>(ReadRegion(item)));
  }
  for (const JsonValue& item : json["staircases"].Items()) map.staircases.push_back(ReadStaircase(item));
  return map;
}

std::string StaircaseLine(const StaircaseReport& report) {
  const OrderedJson line = {{"t_capture_ns", report.t_capture.ns},
                            {"staircase", StaircaseJson(report.staircase)}};
  return Dumped(line);
}

std::vector<StaircaseReport> ReadStaircasesFile(const std::filesystem::path& path) {
  std::vector<StaircaseReport> reports;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    reports.push_back({{json["t_capture_ns"].Integer()}, ReadStaircase(json["staircase"])});
  });
  return reports;
}

}  // namespace terrace
