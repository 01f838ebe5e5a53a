// SPDX-License-Identifier: BSD-3-Clause
// The true scene of a rendered sequence: planes with labels, staircases, and which cells were seen.
#include <charconv>
#include <cmath>
#include <numeric>

#include "core/json_value.h"
#include "datasets/ground_truth.h"
#include "datasets/npz_file.h"

namespace terrace {
namespace {

constexpr const char* kSceneFile = "ground_truth.json";
constexpr const char* kCellsFile = "observed_cells.npz";

std::optional<int> OptionalInt(const JsonValue& json, const char* key) {
  if (!json.Has(key) || json[key].IsNull()) return std::nullopt;
  return static_cast<int>(json[key].Integer());
}

TruePolygon ReadPolygon(const JsonValue& json) {
  TruePolygon polygon;
  polygon.id = static_cast<int>(json["id"].Integer());
  if (json.Has("name")) polygon.name = json["name"].Text();
  polygon.label = json["label"].Text();
  polygon.plane_world = {json["normal"].UnitVector3(), json["offset"].Number()};
  polygon.outline_world = json["vertices"].Points();
  if (json.Has("holes")) {
    for (const JsonValue& hole : json["holes"].Items()) polygon.holes_world.push_back(hole.Points());
  }
  polygon.area_m2 = json["area"].Number();
  polygon.staircase_id = OptionalInt(json, "staircase_id");
  polygon.step_index = OptionalInt(json, "step_index");
  if (json.Has("detail")) polygon.detail = json["detail"].Bool();
  return polygon;
}

std::vector<double> Lengths(const JsonValue& json, const char* key) {
  std::vector<double> lengths;
  if (json.Has(key)) {
    for (const JsonValue& item : json[key].Items()) lengths.push_back(item.Number());
  }
  return lengths;
}

/// The number under `key`, else the mean of the values, else 0.
double NumberOrMean(const JsonValue& json, const char* key, const std::vector<double>& values) {
  if (json.Has(key) && !json[key].IsNull()) return json[key].Number();
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::array<Eigen::Vector3d, 2> ReadEdge(const JsonValue& json) {
  const std::vector<JsonValue> ends = json.Items();
  if (ends.size() != 2) json.Fail("must hold two points");
  return {ends[0].Vector3(), ends[1].Vector3()};
}

TrueStaircase ReadStaircase(const JsonValue& json) {
  TrueStaircase staircase;
  staircase.id = static_cast<int>(json["id"].Integer());
  staircase.num_risers = static_cast<int>(json["n_risers"].Integer());
  staircase.num_treads = static_cast<int>(json["n_treads"].Integer());
  staircase.riser_heights_m = Lengths(json, "riser_heights");
  staircase.tread_depths_m = Lengths(json, "tread_depths");
  staircase.riser_m = NumberOrMean(json, "riser", staircase.riser_heights_m);
  staircase.tread_m = NumberOrMean(json, "tread", staircase.tread_depths_m);
  staircase.width_m = json["width"].Number();
  staircase.direction_up_world = json["up_direction"].UnitVector3();
  staircase.foot_edge_world = ReadEdge(json["foot_edge"]);
  staircase.head_edge_world = ReadEdge(json["top_edge"]);
  for (const JsonValue& id : json["polygon_ids"].Items()) {
    staircase.polygon_ids.push_back(static_cast<int>(id.Integer()));
  }
  return staircase;
}

TrueObject ReadObject(const JsonValue& json) {
  TrueObject object;
  object.name = json["name"].Text();
  object.label = json["label"].Text();
  object.mesh_id = OptionalInt(json, "mesh_id");
  for (const JsonValue& id : json["polygon_ids"].Items()) {
    object.polygon_ids.push_back(static_cast<int>(id.Integer()));
  }
  return object;
}

ObservedCells ReadCells(const NpyArray& mask, const NpyArray& frame, const std::string& where) {
  const std::vector<double> numbers = frame.Doubles();
  if (mask.shape.size() != 2 || numbers.size() != 9) {
    throw FileError(where + ": a mask has two dimensions and its frame nine numbers");
  }
  ObservedCells cells;
  cells.axis_x = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  cells.axis_y = Eigen::Vector3d(numbers[3], numbers[4], numbers[5]);
  cells.origin_m = Eigen::Vector2d(numbers[6], numbers[7]);
  cells.cell_m = numbers[8];
  if (!(cells.cell_m > 0.0)) throw FileError(where + ": the cell size must be positive");
  cells.nx = static_cast<int>(mask.shape[0]);
  cells.ny = static_cast<int>(mask.shape[1]);
  cells.seen = mask.Bools();
  return cells;
}

std::map<Timestamp, std::filesystem::path> ImagesNamedByTime(const std::filesystem::path& folder) {
  std::map<Timestamp, std::filesystem::path> images;
  if (!std::filesystem::is_directory(folder)) return images;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    Timestamp t;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), t.ns);
    if (error == std::errc() && end == stem.data() + stem.size()) images[t] = entry.path();
  }
  return images;
}

}  // namespace

bool HasTrueScene(const std::filesystem::path& sequence) {
  return std::filesystem::is_regular_file(sequence / kSceneFile);
}

TrueScene LoadTrueScene(const std::filesystem::path& sequence) {
  const nlohmann::json document = ReadJsonFile(sequence / kSceneFile);
  const JsonValue json(document, (sequence / kSceneFile).string());
  TrueScene scene;
  for (const JsonValue& item : json["polygons"].Items()) scene.polygons.push_back(ReadPolygon(item));
  for (const JsonValue& item : json["staircases"].Items()) scene.staircases.push_back(ReadStaircase(item));
  if (json.Has("objects")) {
    for (const JsonValue& item : json["objects"].Items()) scene.objects.push_back(ReadObject(item));
  }
  const std::map<std::string, NpyArray> arrays = ReadNpzFile(sequence / kCellsFile);
  for (TruePolygon& polygon : scene.polygons) {
    const std::string id = std::to_string(polygon.id);
    const auto mask = arrays.find("mask_" + id);
    const auto frame = arrays.find("frame_" + id);
    if (mask == arrays.end() || frame == arrays.end()) continue;  // never seen within 5 m
    polygon.observed =
        ReadCells(mask->second, frame->second, (sequence / kCellsFile).string() + " mask_" + id);
  }
  return scene;
}

std::map<Timestamp, std::filesystem::path> TrueDepthImages(const std::filesystem::path& sequence) {
  return ImagesNamedByTime(sequence / "depth");
}

std::map<Timestamp, std::filesystem::path> TrueLabelImages(const std::filesystem::path& sequence) {
  return ImagesNamedByTime(sequence / "labels");
}

}  // namespace terrace
