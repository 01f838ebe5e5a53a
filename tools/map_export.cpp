// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_export.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/print.h"
#include "tools/map_mesh.h"

namespace terrace {
namespace {

using Json = nlohmann::ordered_json;
using Rgb = std::array<std::uint8_t, 3>;

/// As in the pictures of `terrace draw`.
Rgb ExportColour(TerrainLabel label) {
  switch (label) {
    case TerrainLabel::kWalkway:
      return {110, 190, 120};
    case TerrainLabel::kRamp:
      return {245, 195, 60};
    case TerrainLabel::kStairTread:
      return {70, 165, 235};
    case TerrainLabel::kStairRiser:
      return {150, 85, 190};
    case TerrainLabel::kWall:
      return {212, 188, 150};
    case TerrainLabel::kObstacle:
      return {232, 95, 85};
    case TerrainLabel::kLevel:
      return {95, 200, 205};
    case TerrainLabel::kUnknown:
      break;
  }
  return {222, 222, 222};
}

/// Little endian, as both formats and the processors that this runs on have it.
template <typename Number>
void Append(std::string* bytes, Number value) {
  char raw[sizeof(value)];
  std::memcpy(raw, &value, sizeof(value));
  bytes->append(raw, sizeof(value));
}

void AppendFloats(std::string* bytes, const Eigen::Vector3d& v) {
  for (const double value : v) Append(bytes, static_cast<float>(value));
}

/// One primitive of a glTF mesh while it grows.
struct LabelledTriangles {
  std::string positions;
  std::string normals;
  std::string indices;
  std::uint32_t num_vertices = 0;
  std::uint32_t num_indices = 0;
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = Eigen::Vector3f::Constant(std::numeric_limits<float>::lowest());

  void Add(const RegionMesh& mesh, const Eigen::Vector3d& normal) {
    for (const std::uint32_t index : mesh.triangles) Append(&indices, num_vertices + index);
    num_indices += static_cast<std::uint32_t>(mesh.triangles.size());
    num_vertices += static_cast<std::uint32_t>(mesh.vertices_world.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices_world) {
      AppendFloats(&positions, vertex);
      AppendFloats(&normals, normal);
      low = low.cwiseMin(vertex.cast<float>());
      high = high.cwiseMax(vertex.cast<float>());
    }
  }
};

/// Numbers of the glTF specification.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;

/// Puts bytes behind those that are there; returns the number of the accessor.
std::size_t AddAccessor(Json* json, std::string* buffer, const std::string& bytes, int component, int target,
                        std::uint32_t count, const char* type) {
  (*json)["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", buffer->size()}, {"byteLength", bytes.size()}, {"target", target}});
  buffer->append(bytes);
  (*json)["accessors"].push_back({{"bufferView", (*json)["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", count},
                                  {"type", type}});
  return (*json)["accessors"].size() - 1;
}

void AddMesh(Json* json, std::string* buffer, TerrainLabel label, const LabelledTriangles& part) {
  const Rgb rgb = ExportColour(label);
  // glTF's colours are linear, these are of the screen.
  const auto linear = [](std::uint8_t value) { return std::pow(value / 255.0, 2.2); };
  (*json)["materials"].push_back(
      {{"name", Name(label)},
       {"doubleSided", true},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {linear(rgb[0]), linear(rgb[1]), linear(rgb[2]), 1.0}},
         {"metallicFactor", 0.0},
         {"roughnessFactor", 1.0}}}});
  const std::size_t positions =
      AddAccessor(json, buffer, part.positions, kFloat, kArrayBuffer, part.num_vertices, "VEC3");
  (*json)["accessors"][positions]["min"] = {part.low.x(), part.low.y(), part.low.z()};
  (*json)["accessors"][positions]["max"] = {part.high.x(), part.high.y(), part.high.z()};
  const std::size_t normals =
      AddAccessor(json, buffer, part.normals, kFloat, kArrayBuffer, part.num_vertices, "VEC3");
  const std::size_t indices =
      AddAccessor(json, buffer, part.indices, kUnsignedInt, kElementBuffer, part.num_indices, "SCALAR");
  const Json primitive = {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                          {"indices", indices},
                          {"material", (*json)["materials"].size() - 1}};
  (*json)["meshes"].push_back({{"name", Name(label)}, {"primitives", Json::array({primitive})}});
  // z up turned to y up.
  (*json)["nodes"].push_back({{"mesh", (*json)["meshes"].size() - 1},
                              {"name", Name(label)},
                              {"rotation", {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}}});
  (*json)["scenes"][0]["nodes"].push_back((*json)["nodes"].size() - 1);
}

Json ClosedRing(const Ring& ring) {
  Json points = Json::array();
  for (std::size_t i = 0; i <= ring.size(); ++i) {
    const Eigen::Vector3d& p = ring[i % ring.size()];
    points.push_back({p.x(), p.y(), p.z()});
  }
  return points;
}

Json FeatureOf(const TerrainRegion& region) {
  Json rings = Json::array({ClosedRing(region.outline_world)});
  for (const Ring& hole : region.holes_world) rings.push_back(ClosedRing(hole));
  const Eigen::Vector3d& n = region.plane_world.normal;
  Json properties = {{"label", Name(region.label)},
                     {"confidence", region.confidence},
                     {"normal", {n.x(), n.y(), n.z()}},
                     {"offset_m", region.plane_world.offset_m},
                     {"area_m2", region.area_m2},
                     {"predicted", region.predicted()},
                     {"staircase", nullptr},
                     {"step_index", nullptr}};
  if (region.staircase_id) properties["staircase"] = *region.staircase_id;
  if (region.step_index) properties["step_index"] = *region.step_index;
  return {{"type", "Feature"},
          {"id", region.id},
          {"geometry", {{"type", "Polygon"}, {"coordinates", rings}}},
          {"properties", properties}};
}

}  // namespace

std::string PlyBytes(const TerrainMap& map) {
  std::string vertices, faces;
  std::uint32_t num_vertices = 0, num_faces = 0;
  for (const auto& region : map.regions) {
    const RegionMesh mesh = MeshOf(*region);
    const Rgb colour = ExportColour(region->label);
    for (const Eigen::Vector3d& vertex : mesh.vertices_world) {
      AppendFloats(&vertices, vertex);
      AppendFloats(&vertices, region->plane_world.normal);
      for (const std::uint8_t channel : colour) Append(&vertices, channel);
      Append(&vertices, static_cast<std::uint8_t>(region->label));
      Append(&vertices, static_cast<std::int32_t>(region->id));
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3, ++num_faces) {
      Append(&faces, std::uint8_t{3});
      for (std::size_t j = 0; j < 3; ++j)
        Append(&faces, static_cast<std::int32_t>(num_vertices + mesh.triangles[i + j]));
    }
    num_vertices += static_cast<std::uint32_t>(mesh.vertices_world.size());
  }
  return Printed(
             "ply\nformat binary_little_endian 1.0\ncomment Terrace, world frame, metres\nelement vertex %u\n"
             "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
             "property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
             "property uchar label\nproperty int region\nelement face %u\nproperty list uchar int "
             "vertex_indices\n"
             "end_header\n",
             num_vertices, num_faces) +
         vertices + faces;
}

std::string GlbBytes(const TerrainMap& map) {
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "terrace"}}},
               {"scene", 0},
               {"scenes", Json::array({Json::object()})}};
  std::string buffer;
  for (int number = 0; number < kNumTerrainLabels; ++number) {
    const auto label = static_cast<TerrainLabel>(number);
    LabelledTriangles part;
    for (const auto& region : map.regions)
      if (region->label == label) part.Add(MeshOf(*region), region->plane_world.normal);
    if (part.num_indices > 0) AddMesh(&json, &buffer, label, part);
  }
  if (!buffer.empty()) json["buffers"] = Json::array({{{"byteLength", buffer.size()}}});
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');  // chunks are whole words; those of the buffer are

  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;
  std::string bytes;
  Append(&bytes, kMagic);
  Append(&bytes, std::uint32_t{2});
  Append(&bytes, static_cast<std::uint32_t>(12 + 8 + text.size() + (buffer.empty() ? 0 : 8 + buffer.size())));
  Append(&bytes, static_cast<std::uint32_t>(text.size()));
  Append(&bytes, kJson);
  bytes += text;
  if (buffer.empty()) return bytes;
  Append(&bytes, static_cast<std::uint32_t>(buffer.size()));
  Append(&bytes, kBin);
  return bytes + buffer;
}

std::string GeoJsonText(const TerrainMap& map) {
  Json features = Json::array();
  for (const auto& region : map.regions) features.push_back(FeatureOf(*region));
  const Json json = {{"type", "FeatureCollection"},
                     {"frame", "world"},
                     {"unit", "m"},
                     {"t_capture_ns", map.t_capture.ns},
                     {"features", features}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string OctomapText(const TerrainMap& map, double voxel_m, OctomapFormat format) {
  std::vector<LeafIndex> leaves;
  const auto ascending = [](const LeafIndex& a, const LeafIndex& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<OccupiedLeaf> occupied;
  for (const auto& region : map.regions) {
    leaves.clear();
    for (const Eigen::Vector3d& p : PointsOn(*region, 0.5 * voxel_m))
      leaves.push_back((p / voxel_m).array().floor().cast<int>());
    std::sort(leaves.begin(), leaves.end(), ascending);
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    for (const LeafIndex& leaf : leaves) occupied.push_back({leaf, 0, 1});
  }
  const std::vector<std::uint8_t> bytes = OctomapBytes(std::move(occupied), voxel_m, format);
  return {bytes.begin(), bytes.end()};
}

}  // namespace terrace
