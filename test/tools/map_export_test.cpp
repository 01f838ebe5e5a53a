// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_export.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <octomap/OcTree.h>

#include "test/client/made_terrain.h"
#include "tools/map_mesh.h"

namespace terrace {
namespace {

double AreaOf(const RegionMesh& mesh, const Eigen::Vector3d& normal) {
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const Eigen::Vector3d& a = mesh.vertices_world[mesh.triangles[i]];
    const Eigen::Vector3d& b = mesh.vertices_world[mesh.triangles[i + 1]];
    const Eigen::Vector3d& c = mesh.vertices_world[mesh.triangles[i + 2]];
    const double signed_m2 = 0.5 * (b - a).cross(c - a).dot(normal);
    EXPECT_GT(signed_m2, -1e-9) << "a triangle runs the wrong way round";
    area_m2 += signed_m2;
  }
  return area_m2;
}

/// A floor with a hole and, over a part of it, a platform.
TerrainMap FloorAndPlatform() {
  return *MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.01), Rectangle(0, 0, 2, 1),
                              {Rectangle(0.5, 0.25, 1, 0.75)}),
                   MadeRegion(7, TerrainLabel::kStairTread, LevelAt(0.17), Rectangle(2, 0, 2.3, 1))});
}

TEST(MapMeshTest, TrianglesHaveTheAreaOfTheRegionWithItsHolesAndFaceAsItDoes) {
  ScatteredTerrain terrain(5);
  for (int i = 1; i <= 60; ++i) {
    const auto region = terrain.Region(i, 5.0, 30);
    double area_m2 = SignedArea(region->outline_world, region->plane_world.normal);
    for (const Ring& hole : region->holes_world) area_m2 += SignedArea(hole, region->plane_world.normal);
    EXPECT_NEAR(AreaOf(MeshOf(*region), region->plane_world.normal), area_m2, 1e-6) << i;
  }
}

template <typename Number>
Number NumberAt(const std::string& bytes, std::size_t at) {
  Number value{};
  EXPECT_LE(at + sizeof(value), bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

TEST(MapExportTest, APlyFileHasAsManyBytesAsItsHeaderSaysAndItsTrianglesTheArea) {
  const std::string ply = PlyBytes(FloorAndPlatform());
  const std::size_t body = ply.find("end_header\n") + 11;
  std::istringstream header(ply.substr(0, body));
  std::size_t num_vertices = 0, num_faces = 0;
  for (std::string word; header >> word;) {
    if (word == "vertex") header >> num_vertices;
    if (word == "face") header >> num_faces;
  }
  constexpr std::size_t kVertexBytes = 6 * 4 + 4 + 4, kFaceBytes = 1 + 3 * 4;
  ASSERT_GT(num_faces, 0u);
  ASSERT_EQ(ply.size(), body + num_vertices * kVertexBytes + num_faces * kFaceBytes);
  const auto vertex = [&](std::size_t i) {
    const std::size_t at = body + i * kVertexBytes;
    return Eigen::Vector3d(NumberAt<float>(ply, at), NumberAt<float>(ply, at + 4),
                           NumberAt<float>(ply, at + 8));
  };
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < num_faces; ++i) {
    const std::size_t at = body + num_vertices * kVertexBytes + i * kFaceBytes;
    ASSERT_EQ(NumberAt<std::uint8_t>(ply, at), 3);
    std::size_t corner[3];
    for (std::size_t j = 0; j < 3; ++j) {
      corner[j] = static_cast<std::size_t>(NumberAt<std::int32_t>(ply, at + 1 + 4 * j));
      ASSERT_LT(corner[j], num_vertices);
    }
    area_m2 += 0.5 * (vertex(corner[1]) - vertex(corner[0])).cross(vertex(corner[2]) - vertex(corner[0])).z();
  }
  EXPECT_NEAR(area_m2, 2.0 - 0.25 + 0.3, 1e-5);
  EXPECT_EQ(NumberAt<std::int32_t>(ply, body + 28), 1);
}

TEST(MapExportTest, AGlbFileHoldsOneMeshALabelWithinItsBuffer) {
  const std::string glb = GlbBytes(FloorAndPlatform());
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(NumberAt<std::uint32_t>(glb, 4), 2u);
  EXPECT_EQ(NumberAt<std::uint32_t>(glb, 8), glb.size());
  const auto text_size = NumberAt<std::uint32_t>(glb, 12);
  ASSERT_EQ(glb.substr(16, 4), "JSON");
  const auto json = nlohmann::json::parse(glb.substr(20, text_size));
  const auto buffer_size = NumberAt<std::uint32_t>(glb, 20 + text_size);
  EXPECT_EQ(glb.size(), 28 + text_size + buffer_size);
  EXPECT_EQ(json["buffers"][0]["byteLength"], buffer_size);
  ASSERT_EQ(json["meshes"].size(), 2u);
  EXPECT_EQ(json["meshes"][0]["name"], "walkway");
  EXPECT_EQ(json["meshes"][1]["name"], "stair_tread");
  for (const auto& view : json["bufferViews"])
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(), buffer_size);
  for (const auto& mesh : json["meshes"]) {
    const auto& primitive = mesh["primitives"][0];
    const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
    const auto& indices = json["accessors"][primitive["indices"].get<std::size_t>()];
    const auto& view = json["bufferViews"][indices["bufferView"].get<std::size_t>()];
    ASSERT_EQ(view["byteLength"].get<std::size_t>(), 4 * indices["count"].get<std::size_t>());
    for (std::size_t i = 0; i < indices["count"].get<std::size_t>(); ++i)
      EXPECT_LT(NumberAt<std::uint32_t>(glb, 28 + text_size + view["byteOffset"].get<std::size_t>() + 4 * i),
                positions["count"].get<std::uint32_t>());
  }
  EXPECT_EQ(json["accessors"][0]["max"][0], 2.0);
  const std::string empty = GlbBytes(TerrainMap());
  EXPECT_EQ(NumberAt<std::uint32_t>(empty, 8), empty.size());
}

TEST(MapExportTest, GeoJsonHasClosedRingsWithHoles) {
  const auto json = nlohmann::json::parse(GeoJsonText(FloorAndPlatform()));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 2u);
  const auto& floor = json["features"][0];
  EXPECT_EQ(floor["id"], 1);
  EXPECT_EQ(floor["properties"]["label"], "walkway");
  const auto& rings = floor["geometry"]["coordinates"];
  ASSERT_EQ(rings.size(), 2u);
  EXPECT_EQ(rings[0].size(), 5u);
  for (const auto& ring : rings) EXPECT_EQ(ring.front(), ring.back());
}

TEST(MapExportTest, OctomapHasAVoxelExactlyWhereARegionPassesThrough) {
  constexpr double kVoxel_m = 0.05;
  std::istringstream in(OctomapText(FloorAndPlatform(), kVoxel_m, OctomapFormat::kBt));
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary(in));
  EXPECT_DOUBLE_EQ(tree.getResolution(), kVoxel_m);
  const auto is_occupied = [&](double x, double y, double z) {
    const octomap::OcTreeNode* node = tree.search(x, y, z);
    return node != nullptr && tree.isNodeOccupied(node);
  };
  for (double x = 0.025; x < 2.5; x += kVoxel_m) {
    for (double y = 0.025; y < 1.0; y += kVoxel_m) {
      const bool in_hole = x > 0.5 && x < 1.0 && y > 0.25 && y < 0.75;
      // A voxel that a border runs along may have it on either side.
      const bool near_hole_border =
          x > 0.45 && x < 1.05 && y > 0.2 && y < 0.8 && !(x > 0.55 && x < 0.95 && y > 0.3 && y < 0.7);
      const bool near_end = x > 1.95 && x < 2.05;
      if (!near_hole_border && !near_end) {
        EXPECT_EQ(is_occupied(x, y, 0.025), x < 2.0 && !in_hole) << x << " " << y;
      }
      if (!near_end && !(x > 2.25 && x < 2.35)) {
        EXPECT_EQ(is_occupied(x, y, 0.175), x > 2.0 && x < 2.3) << x;
      }
      EXPECT_FALSE(is_occupied(x, y, 0.375));
    }
  }
}

}  // namespace
}  // namespace terrace
