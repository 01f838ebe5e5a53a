// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/json_value.h"
#include "datasets/ground_truth.h"
#include "datasets/npz_file.h"

namespace terrace {
namespace {

std::vector<std::uint8_t> Npy(const std::string& header, const std::vector<std::uint8_t>& data) {
  std::vector<std::uint8_t> bytes = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes.push_back(static_cast<std::uint8_t>(header.size() & 255));
  bytes.push_back(static_cast<std::uint8_t>(header.size() >> 8));
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

TEST(NpyTest, ReadsABooleanMask) {
  const NpyArray array =
      ParseNpy(Npy("{'descr': '|b1', 'fortran_order': False, 'shape': (2, 3), }\n", {1, 0, 1, 0, 1, 1}), "a");
  EXPECT_EQ(array.shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(array.Bools(), (std::vector<std::uint8_t>{1, 0, 1, 0, 1, 1}));
  EXPECT_THROW(array.Doubles(), FileError);
}

TEST(NpyTest, RefusesWhatDoesNotFitInsteadOfAllocatingForIt) {
  const std::vector<std::string> headers = {
      "{'descr': '|b1', 'fortran_order': False, 'shape': (2, 4), }",
      "{'descr': '|b1', 'fortran_order': False, 'shape': (99999999999999999999, 2), }",
      "{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }",
      "{'descr': '|b1', 'fortran_order': True, 'shape': (2, 3), }",
      "{'descr': '|O', 'fortran_order': False, 'shape': (6,), }",
      "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (6,), }",
      "{'descr': '|b1', 'fortran_order': False, }",
      "{'descr': '|b1', 'fortran_order': False, 'shape':",
      "",
  };
  for (const std::string& header : headers) {
    EXPECT_THROW(ParseNpy(Npy(header, {1, 0, 1, 0, 1, 1}), "a"), FileError) << header;
  }
  std::vector<std::uint8_t> cut = Npy("{'descr': '|b1', 'fortran_order': False, 'shape': (2, 3), }", {1, 1});
  for (std::size_t length = 0; length < cut.size(); ++length) {
    EXPECT_THROW(ParseNpy({cut.begin(), cut.begin() + static_cast<std::ptrdiff_t>(length)}, "a"), FileError);
  }
}

TEST(GroundTruthSceneTest, ReadsTheRenderedCorridorWithStairs) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA does not name the folder with the recordings";
  const std::filesystem::path sequence = std::filesystem::path(data) / "corridor_stairs";
  const TrueScene scene = LoadTrueScene(sequence);
  EXPECT_EQ(scene.polygons.size(), 143u);
  ASSERT_EQ(scene.staircases.size(), 1u);
  EXPECT_EQ(scene.staircases[0].num_risers, 6);
  EXPECT_TRUE(scene.staircases[0].head_edge_world[1].isApprox(Eigen::Vector3d(8.6, -0.7, 1.02)));
  const TruePolygon& floor = scene.polygons[0];
  EXPECT_EQ(floor.label, "walkway");
  EXPECT_EQ(floor.holes_world.size(), 2u);
  // The first cell of the 210 x 50 grid that begins at (-1.2, -1.0).
  ASSERT_EQ(floor.observed.seen.size(), 210u * 50u);
  EXPECT_TRUE(floor.observed.Centre(0, 0, floor.plane_world).isApprox(Eigen::Vector3d(-1.18, -0.98, 0)));
  EXPECT_EQ(TrueDepthImages(sequence).size(), 29u);
  EXPECT_EQ(TrueLabelImages(sequence).size(), 29u);
}

}  // namespace
}  // namespace terrace
