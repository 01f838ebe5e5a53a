// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrace_file.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using Bytes = std::vector<std::uint8_t>;

TerrainMap ExampleMap(int num_regions) {
  TerrainMap map = ExampleMaps(17).First(num_regions);
  map.T_body_left = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0.0, 0.1));
  map.epoch = 2;
  return map;
}

/// Why the bytes are refused; empty: they are not.
std::string Refusal(const Bytes& bytes) {
  try {
    static_cast<void>(FromTerraceFile(bytes, "room.terrace"));
    return "";
  } catch (const FileError& error) {
    return error.what();
  }
}

void ExpectSameRegion(const TerrainRegion& a, const TerrainRegion& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.why, b.why);
  EXPECT_EQ(a.plane_world.normal, b.plane_world.normal);
  EXPECT_EQ(a.plane_world.offset_m, b.plane_world.offset_m);
  EXPECT_EQ(a.plane_covariance, b.plane_covariance);
  EXPECT_EQ(a.centroid_world, b.centroid_world);
  EXPECT_EQ(a.rms_m, b.rms_m);
  EXPECT_EQ(a.area_m2, b.area_m2);
  EXPECT_EQ(a.support, b.support);
  EXPECT_EQ(a.num_observations, b.num_observations);
  EXPECT_EQ(a.first_seen, b.first_seen);
  EXPECT_EQ(a.last_seen, b.last_seen);
  EXPECT_EQ(a.staircase_id, b.staircase_id);
  EXPECT_EQ(a.step_index, b.step_index);
  EXPECT_EQ(a.outline_world, b.outline_world);
  EXPECT_EQ(a.holes_world, b.holes_world);
  EXPECT_EQ(a.edges, b.edges);
}

void ExpectSameStaircase(const Staircase& a, const Staircase& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.num_risers, b.num_risers);
  EXPECT_EQ(a.num_treads, b.num_treads);
  EXPECT_EQ(a.riser_m, b.riser_m);
  EXPECT_EQ(a.riser_sigma_m, b.riser_sigma_m);
  EXPECT_EQ(a.tread_m, b.tread_m);
  EXPECT_EQ(a.tread_sigma_m, b.tread_sigma_m);
  EXPECT_EQ(a.width_m, b.width_m);
  EXPECT_EQ(a.foot_edge_world, b.foot_edge_world);
  EXPECT_EQ(a.head_edge_world, b.head_edge_world);
  EXPECT_EQ(a.direction_up_world, b.direction_up_world);
  EXPECT_EQ(a.turn_per_step_rad, b.turn_per_step_rad);
  EXPECT_EQ(a.pitch_rad, b.pitch_rad);
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.region_ids, b.region_ids);
  EXPECT_EQ(a.last_seen, b.last_seen);
}

TEST(TerraceFileTest, GivesBackEveryBitOfAMap) {
  const TerrainMap map = ExampleMap(60);
  const TerrainMap read = *FromTerraceFile(TerraceFileBytes(map), "room.terrace").map;
  EXPECT_EQ(read.t_capture, map.t_capture);
  EXPECT_EQ(read.seq, map.seq);
  EXPECT_EQ(read.map_id, map.map_id);
  EXPECT_EQ(read.epoch, map.epoch);
  EXPECT_EQ(read.T_world_left.matrix(), map.T_world_left.matrix());
  EXPECT_EQ(read.covariance, map.covariance);
  ASSERT_TRUE(read.T_body_left);
  EXPECT_EQ(read.T_body_left->matrix(), map.T_body_left->matrix());
  EXPECT_EQ(read.gravity.down_world, map.gravity.down_world);
  EXPECT_EQ(read.gravity.sigma_rad, map.gravity.sigma_rad);
  EXPECT_EQ(read.gravity.source, map.gravity.source);
  ASSERT_EQ(read.regions.size(), map.regions.size());
  for (std::size_t i = 0; i < map.regions.size(); ++i) ExpectSameRegion(*read.regions[i], *map.regions[i]);
  ASSERT_EQ(read.staircases.size(), map.staircases.size());
  for (std::size_t i = 0; i < map.staircases.size(); ++i)
    ExpectSameStaircase(read.staircases[i], map.staircases[i]);
  EXPECT_EQ(TerraceFileBytes(read), TerraceFileBytes(map));
}

TEST(TerraceFileTest, AMapWithoutAnythingIsAMap) {
  const TerrainMap read = *FromTerraceFile(TerraceFileBytes(TerrainMap()), "room.terrace").map;
  EXPECT_TRUE(read.regions.empty());
  EXPECT_FALSE(read.T_body_left);
}

std::vector<PlaceView> ExampleViews() {
  std::vector<PlaceView> views(2);
  views[0].t_capture = Timestamp{1'234'567};
  views[0].T_world_left =
      Eigen::Translation3d(1.0, -2.0, 0.5) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ());
  views[0].corners = {{{0.1, 0.2, 3.0}, {1, 2, 3, ~std::uint64_t{0}}},
                      {{-0.4, 0.0, 1.0 / 3.0}, {0, 0, 7, 0}}};
  return views;
}

TEST(TerraceFileTest, GivesBackTheViewsThatWereSavedWithAMap) {
  const TerrainMap map = ExampleMap(5);
  const std::vector<PlaceView> views = ExampleViews();
  const SavedMap read = FromTerraceFile(TerraceFileBytes(map, views), "room.terrace");
  EXPECT_EQ(TerraceFileBytes(*read.map), TerraceFileBytes(map));
  ASSERT_EQ(read.views.size(), 2u);
  EXPECT_EQ(read.views[0].t_capture, views[0].t_capture);
  EXPECT_EQ(read.views[0].T_world_left.matrix(), views[0].T_world_left.matrix());
  ASSERT_EQ(read.views[0].corners.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.views[0].corners[i].p_left, views[0].corners[i].p_left);
    EXPECT_EQ(read.views[0].corners[i].descriptor, views[0].corners[i].descriptor);
  }
  EXPECT_TRUE(read.views[1].corners.empty());
}

TEST(TerraceFileTest, ViewsThatAreCutOrNoPosesAreRefused) {
  std::vector<PlaceView> views = ExampleViews();
  const Bytes whole = TerraceFileBytes(ExampleMap(1), views);
  const std::size_t without = TerraceFileBytes(ExampleMap(1)).size();
  for (std::size_t size = without; size < whole.size(); size += 8)
    EXPECT_NE(Refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
  views[1].T_world_left.linear() *= 2.0;
  EXPECT_NE(Refusal(TerraceFileBytes(ExampleMap(1), views)).find("scale"), std::string::npos);
}

TEST(TerraceFileTest, ACutFileIsRefusedWithPlaceAndReason) {
  const Bytes whole = TerraceFileBytes(ExampleMap(40));
  ASSERT_EQ(Refusal(whole), "");
  for (std::size_t size = 0; size < whole.size(); size += 10) {
    const std::string refusal =
        Refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_EQ(refusal.rfind("room.terrace: byte ", 0), 0u) << size << ": " << refusal;
  }
  Bytes longer = whole;
  longer.resize(whole.size() + 8);
  EXPECT_NE(Refusal(longer), "");
}

TEST(TerraceFileTest, EverySingleBitThatFlipsIsFound) {
  const Bytes whole = TerraceFileBytes(ExampleMap(3));
  Bytes damaged = whole;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      damaged[at] ^= static_cast<std::uint8_t>(1 << bit);
      EXPECT_NE(Refusal(damaged), "") << "byte " << at << ", bit " << bit;
      damaged[at] = whole[at];
    }
  }
}

/// Bytes with a good checksum whatever is in them, as only another writer could make them.
Bytes Resealed(Bytes bytes) {
  const std::uint64_t size = bytes.size();
  for (int i = 0; i < 8; ++i)
    bytes[16 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(size >> (8 * i));
  std::uint64_t sum = 0xcbf29ce484222325ULL;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < 8; ++i) word |= std::uint64_t{bytes[at + i]} << (8 * i);
    if (at != 24) sum = (sum ^ word) * 0x100000001b3ULL;
  }
  for (int i = 0; i < 8; ++i)
    bytes[24 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(sum >> (8 * i));
  return bytes;
}

TEST(TerraceFileTest, HostileNumbersUnderAGoodChecksumNeitherCrashNorAllocate) {
  const Bytes whole = TerraceFileBytes(ExampleMap(5));
  ASSERT_EQ(Resealed(whole), whole);
  for (std::size_t at = 32; at + 4 <= whole.size(); ++at) {
    Bytes hostile = whole;
    for (std::size_t i = 0; i < 4; ++i) hostile[at + i] = 0xff;
    static_cast<void>(Refusal(Resealed(hostile)));
    if (at % 8 == 0)
      static_cast<void>(
          Refusal(Resealed(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at)))));
  }
}

TEST(TerraceFileTest, SavesAndLoadsAndSaysWhatCannotBe) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "terrace_file_test";
  std::filesystem::create_directories(folder);
  const TerrainMap map = ExampleMap(10);
  SaveTerraceFile(folder / "room.terrace", map);
  EXPECT_EQ(TerraceFileBytes(*LoadTerraceFile(folder / "room.terrace").map), TerraceFileBytes(map));
  EXPECT_FALSE(std::filesystem::exists(folder / "room.terrace.partial"));
  EXPECT_THROW(static_cast<void>(LoadTerraceFile(folder / "none.terrace")), FileError);
  EXPECT_THROW(SaveTerraceFile(folder / "none" / "room.terrace", map), FileError);
  std::ofstream(folder / "text.terrace") << "this has the size of a header at least, but it is none\n";
  EXPECT_THROW(static_cast<void>(LoadTerraceFile(folder / "text.terrace")), FileError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace terrace
