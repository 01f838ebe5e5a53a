// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_window.h"

#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kRowCell_m = 0.32;

class SurfaceWindowTest : public ::testing::Test {
 protected:
  /// A surface of one row of cells along x with one polygon of the same number; its first cell begins at x.
  void AddRow(double x_m, int num_cells, int height_cells = 0) {
    const int first = static_cast<int>(std::lround(x_m / kRowCell_m));
    SurfaceId id = kNoSurface;
    for (int i = 0; i < num_cells; ++i) {
      const CellKey key{first + i, 0, height_cells};
      const Eigen::Vector3d centre = kRowCell_m * (Eigen::Vector3d(key.x, key.y, key.z).array() + 0.5);
      Patch patch;
      patch.plane_world = {Eigen::Vector3d::UnitZ(), centre.z()};
      for (const double u : {-0.15, 0.15})
        for (const double v : {-0.15, 0.15}) patch.moments.Add(1e5, {u, v, 0.0});
      patch.low = {-0.15F, -0.15F, 0.0F};
      patch.high = {0.15F, 0.15F, 0.0F};
      patch.area_m2 = 0.09;
      const MemberRef ref = store_.Add(key, centre, patch);
      if (id == kNoSurface)
        store_.Found(ref);
      else
        store_.Join(ref, id);
      id = store_.At(ref).surface;
    }
    store_.RefitTouched();
    Surface& surface = store_.surfaces().at(id);
    surface.polygons = {id};
    surface.pieces.emplace_back();
    surface.trace_now = false;
    auto polygon = std::make_shared<Polygon>();
    polygon->id = id;
    polygons_.Put(polygon);
  }

  std::vector<PolygonId> MoveTo(SurfaceWindow* window, double x_m, const std::set<SurfaceId>& waiting = {}) {
    return window->Move({x_m, 0.1, 0.1}, waiting, polygons_, &store_);
  }

  std::vector<SurfaceId> InStore() const {
    std::vector<SurfaceId> ids;
    for (const auto& [id, surface] : store_.surfaces()) ids.push_back(id);
    return ids;
  }

  SurfaceStore store_;
  PolygonMap polygons_;
};

TEST_F(SurfaceWindowTest, TakesAwayWhatIsFarAndBringsItBack) {
  SurfaceWindow window({10.0});
  for (const double x : {0.0, 8.0, 20.0, 40.0}) AddRow(x, 3);
  EXPECT_THAT(MoveTo(&window, 0.0), IsEmpty());
  EXPECT_THAT(InStore(), ElementsAre(1, 2));
  EXPECT_GT(window.memory_bytes(), 0);
  MoveTo(&window, 30.0);
  EXPECT_THAT(InStore(), ElementsAre(3, 4));
  MoveTo(&window, 0.0);
  EXPECT_THAT(InStore(), ElementsAre(1, 2));
  EXPECT_EQ(store_.surfaces().at(1).cells.size(), 3U);
  EXPECT_THAT(store_.surfaces().at(1).polygons, ElementsAre(1));
}

TEST_F(SurfaceWindowTest, KeepsWhatMeetsASurfaceOfTheWindow) {
  SurfaceWindow window({10.0});
  AddRow(0.0, 60);     // reaches 19 m far
  AddRow(17.6, 3, 1);  // above its end
  AddRow(17.6, 3, 9);  // far above it
  MoveTo(&window, 0.0);
  EXPECT_THAT(InStore(), ElementsAre(1, 2));
  MoveTo(&window, 60.0);
  EXPECT_THAT(InStore(), IsEmpty());
  MoveTo(&window, -5.0);
  EXPECT_THAT(InStore(), ElementsAre(1, 2));
}

TEST_F(SurfaceWindowTest, DoesNotTakeAwayWhatWaitsNorKeepWhatWasNeverPublished) {
  SurfaceWindow window({10.0});
  AddRow(40.0, 3);
  AddRow(45.0, 3);
  store_.surfaces().at(2).polygons.clear();
  MoveTo(&window, 0.0, {1});
  EXPECT_THAT(InStore(), ElementsAre(1));
  EXPECT_TRUE(window.far().empty());
}

TEST_F(SurfaceWindowTest, ForgetsWhatLiesFartherAwayThanAnythingIsKept) {
  SurfaceWindow window({10.0, 30.0});
  for (const double x : {0.0, 20.0, 50.0}) AddRow(x, 3);
  EXPECT_THAT(MoveTo(&window, 0.0), ElementsAre(3));
  EXPECT_THAT(MoveTo(&window, 45.0), ElementsAre(1));
  EXPECT_EQ(window.far().size() + store_.surfaces().size(), 1U);
}

TEST_F(SurfaceWindowTest, CountsItsHeapAsSurfacesComeAndGo) {
  SurfaceWindow window({10.0});
  for (const double x : {0.0, 20.0, 23.0, 40.0}) AddRow(x, 7);
  MoveTo(&window, 0.0);
  const std::int64_t three = window.memory_bytes();
  MoveTo(&window, 100.0);
  EXPECT_EQ(window.far().size(), 4U);
  EXPECT_GT(window.memory_bytes(), three);
  MoveTo(&window, 0.0);
  EXPECT_EQ(window.memory_bytes(), three);
  // The slow way.
  std::int64_t parts = 0;
  for (const auto& [id, far] : window.far()) parts += far.memory_bytes();
  EXPECT_GT(window.memory_bytes(), parts);
  MoveTo(&window, 21.0);
  MoveTo(&window, 30.0);
  EXPECT_EQ(window.far().size(), 1U);
}

}  // namespace
}  // namespace terrace
