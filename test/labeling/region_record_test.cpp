// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/region_record.h"

#include <memory>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(RegionRecordTest, RevisionsGoOnFromThatOfThePolygonWhenItIsFirstTold) {
  auto polygon = std::make_shared<Polygon>();
  polygon->id = 3;
  polygon->revision = 21;  // it came back
  RegionRecord record;
  record.Tell(polygon, Verdict(TerrainLabel::kUnknown, 0.5, {}), nullptr);
  EXPECT_EQ(record.region()->revision, 21);
  record.Tell(polygon, Verdict(TerrainLabel::kUnknown, 0.5, {}), nullptr);
  EXPECT_EQ(record.region()->revision, 21) << "nothing has changed";
  record.Tell(polygon, Verdict(TerrainLabel::kWalkway, 0.9, {}), nullptr);
  EXPECT_EQ(record.region()->revision, 22);
}

}  // namespace
}  // namespace terrace
