// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/polygon_merger.h"

#include <cstring>
#include <map>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "polygonization/cell_modeller.h"
#include "stereo/cloud.h"
#include "test/mapping/disparity_of_planes.h"

namespace terrace {
namespace {

constexpr float kSigma_px = 0.1F;
constexpr double kDegree = std::numbers::pi / 180.0;

/// Octree, modeller and merger in a row, as the pipeline calls them.
class Mapper {
 public:
  const PolygonUpdate& See(const PlaneWorld& world, PoseEstimate pose) {
    pose.t_capture = {1'000'000'000 + pose.frame_id * 50'000'000};
    const DisparityImage image = DisparityOf(world, TestCamera(), pose, kSigma_px, &random_);
    const Cloud cloud = Triangulate(image, TestCamera(), {});
    update_ = merger_.Merge(modeller_.Fit(octree_, octree_.Insert(cloud, TestCamera(), pose)),
                            {TestCamera(), pose.T_world_left, &image});
    return update_;
  }
  const PolygonUpdate& update() const { return update_; }
  const PolygonMap& polygons() const { return merger_.polygons(); }
  std::vector<PolygonPtr> All() const {
    std::vector<PolygonPtr> all;
    for (const auto& [id, entry] : merger_.polygons()) all.push_back(entry.polygon);
    return all;
  }

  /// The largest polygon that lies on a rectangle's plane (3 cm, 10 deg) over its middle.
  PolygonPtr On(const PlaneWorld::Rectangle& r) const {
    PolygonPtr best;
    for (const PolygonPtr& p : All()) {
      const Eigen::Vector3d middle = r.corner + 0.5 * (r.edge_x + r.edge_y);
      if (p->plane_world.normal.dot(r.normal()) < std::cos(10 * kDegree)) continue;
      if (std::abs(p->plane_world.SignedDistance(middle)) > 0.03) continue;
      Eigen::Vector3d low = p->outline_world[0], high = low;
      for (const Eigen::Vector3d& v : p->outline_world) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
      }
      if (((middle - low).array() < -0.03).any() || ((high - middle).array() < -0.03).any()) continue;
      if (best == nullptr || p->area_m2 > best->area_m2) best = p;
    }
    return best;
  }

 private:
  std::mt19937 random_{1};
  TerrainOctree octree_{MappingConfig{}};
  CellModeller modeller_{ModellingConfig{}};
  PolygonMerger merger_{MergingConfig{}};
  PolygonUpdate update_;
};

PlaneWorld StairsWorld() {
  PlaneWorld world;
  world.AddFloor(-1, 1.5, -0.6, 0.6, 0);
  world.AddStairs(1.5, -0.6, 0.6, 0.17, 0.28, 4);
  return world;
}

TEST(PolygonMergerTest, FindsOneFloorWithinMillimetres) {
  PlaneWorld world;
  world.AddFloor(0, 2, -1, 1, 0);
  Mapper mapper;
  for (int i = 0; i < 20; ++i) mapper.See(world, LookFrom(i, -0.6 + 0.02 * i, 0, 0.45, 0, 0.5));
  ASSERT_EQ(mapper.All().size(), 1U);
  const PolygonPtr polygon = mapper.All()[0];
  const Polygon& floor = *polygon;
  EXPECT_NEAR(floor.plane_world.offset_m, 0.0, 0.002);
  EXPECT_GT(floor.plane_world.normal.z(), std::cos(0.2 * kDegree));
  EXPECT_NEAR(floor.area_m2, 4.0, 0.3);  // the nearest corners are out of view
  EXPECT_LT(floor.rms_m, 0.005);
  EXPECT_GT(SignedArea(floor.outline_world, floor.plane_world.normal), 0.0);
  for (const Eigen::Vector3d& p : floor.outline_world)
    EXPECT_NEAR(floor.plane_world.SignedDistance(p), 0.0, 1e-9);
}

TEST(PolygonMergerTest, FindsEveryTreadAndRiserOfAFlight) {
  const PlaneWorld world = StairsWorld();
  Mapper mapper;
  for (int i = 0; i < 24; ++i) mapper.See(world, LookFrom(i, 0.5 + 0.05 * std::min(i, 16), 0, 0.9, 0, 0.35));
  for (std::size_t i = 1; i < world.rectangles.size(); ++i) {
    const PlaneWorld::Rectangle& truth = world.rectangles[i];
    const PolygonPtr polygon = mapper.On(truth);
    ASSERT_NE(polygon, nullptr) << "face " << i;
    const Eigen::Vector3d middle = truth.corner + 0.5 * (truth.edge_x + truth.edge_y);
    EXPECT_NEAR(polygon->plane_world.SignedDistance(middle), 0.0, 0.005) << "face " << i;
    EXPECT_NEAR(polygon->area_m2, truth.area_m2(), 0.2 * truth.area_m2()) << "face " << i;
  }
}

TEST(PolygonMergerTest, PartsARiserFromTheWallsThatGoOnBesideItInItsPlane) {
  PlaneWorld world;
  world.AddFloor(-1, 1.0, -1, 1, 0);
  world.AddFaceTowardsMinusX(1.0, -0.35, 0.35, 0.0, 0.2);
  world.AddFloor(1.0, 1.5, -0.35, 0.35, 0.2);
  world.AddFaceTowardsMinusX(1.0, -1.0, -0.35, 0.0, 0.8);
  world.AddFaceTowardsMinusX(1.0, 0.35, 1.0, 0.0, 0.8);
  Mapper mapper;
  for (int i = 0; i < 24; ++i) mapper.See(world, LookFrom(i, -0.4 + 0.01 * i, 0, 0.7, 0, 0.3));
  const PolygonPtr riser = mapper.On(world.rectangles[1]);
  const PolygonPtr left = mapper.On(world.rectangles[3]), right = mapper.On(world.rectangles[4]);
  ASSERT_TRUE(riser != nullptr && left != nullptr && right != nullptr);
  EXPECT_NE(riser->id, left->id);
  EXPECT_NE(riser->id, right->id);
  EXPECT_NE(left->id, right->id);
  EXPECT_NEAR(riser->area_m2, 0.7 * 0.2, 0.02);
}

TEST(PolygonMergerTest, KeepsTheIdOfAPolygonThatGrows) {
  PlaneWorld world;
  world.AddFloor(0, 6, -1, 1, 0);
  Mapper mapper;
  PolygonId id = 0;
  int revision = 0;
  for (int i = 0; i < 30; ++i) {
    mapper.See(world, LookFrom(i, -0.5 + 0.1 * i, 0, 0.45, 0, 0.5));
    if (i == 0) continue;  // nothing is believed that one frame alone has seen
    ASSERT_FALSE(mapper.polygons().empty());
    PolygonPtr largest = mapper.polygons().begin()->second.polygon;
    for (const PolygonPtr& p : mapper.All())
      if (p->area_m2 > largest->area_m2) largest = p;
    if (id == 0) id = largest->id;
    EXPECT_EQ(largest->id, id);
    EXPECT_GE(largest->revision, revision);
    revision = largest->revision;
  }
}

TEST(PolygonMergerTest, KeepsTwoCoplanarPolygonsApartAcrossAGap) {
  PlaneWorld world;
  world.AddFloor(0.6, 1.4, -0.6, -0.1, 0);
  world.AddFloor(0.6, 1.4, 0.1, 0.6, 0);
  Mapper mapper;
  for (int i = 0; i < 8; ++i) mapper.See(world, LookFrom(i, 0.02 * i, 0, 0.5, 0, 0.5));
  EXPECT_EQ(mapper.All().size(), 2U);
}

TEST(PolygonMergerTest, RemovesThePolygonOfABoxThatHasLeft) {
  PlaneWorld empty;
  empty.AddFloor(0, 3, -1, 1, 0);
  PlaneWorld with_box = empty;
  with_box.AddBox(1.0, 1.4, -0.2, 0.2, 0, 0.2);
  Mapper mapper;
  for (int i = 0; i < 8; ++i) mapper.See(with_box, LookFrom(i, 0, 0, 0.6, 0, 0.5));
  const PlaneWorld::Rectangle& top = with_box.rectangles[1];
  ASSERT_NE(mapper.On(top), nullptr);
  const PolygonId id = mapper.On(top)->id;
  bool removed = false;
  for (int i = 8; i < 40; ++i) {
    const PolygonUpdate& update = mapper.See(empty, LookFrom(i, 0, 0, 0.6, 0, 0.5));
    removed = removed || std::count(update.removed.begin(), update.removed.end(), id) == 1;
  }
  EXPECT_TRUE(removed);
  EXPECT_EQ(mapper.On(top), nullptr);
}

TEST(PolygonMergerTest, ABoxThatIsPutBackHasItsIdAgainUnderAGreaterRevision) {
  PlaneWorld empty;
  empty.AddFloor(0, 3, -1, 1, 0);
  PlaneWorld with_box = empty;
  with_box.AddBox(1.0, 1.4, -0.2, 0.2, 0, 0.2);
  const PlaneWorld::Rectangle top = with_box.rectangles[1];
  Mapper mapper;
  int frame = 0;
  for (; frame < 8; ++frame) mapper.See(with_box, LookFrom(frame, 0, 0, 0.6, 0, 0.5));
  const PolygonPtr before = mapper.On(top);
  ASSERT_NE(before, nullptr);
  for (; frame < 30; ++frame) mapper.See(empty, LookFrom(frame, 0, 0, 0.6, 0, 0.5));
  ASSERT_EQ(mapper.On(top), nullptr);
  for (; frame < 40; ++frame) mapper.See(with_box, LookFrom(frame, 0, 0, 0.6, 0, 0.5));
  const PolygonPtr after = mapper.On(top);
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->id, before->id);
  EXPECT_GT(after->revision, before->revision);
  EXPECT_EQ(after->first_seen, before->first_seen);
}

TEST(PolygonMergerTest, GivesTheSameBitsForAnyNumberOfThreads) {
  const PlaneWorld world = StairsWorld();
  std::vector<std::vector<double>> runs;
  for (const std::size_t num_threads : {1, 4}) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, num_threads);
    Mapper mapper;
    std::vector<double> all;
    for (int i = 0; i < 5; ++i) mapper.See(world, LookFrom(i, 0.5 + 0.1 * i, 0, 0.9, 0, 0.35));
    for (const PolygonPtr& p : mapper.All()) {
      all.push_back(static_cast<double>(p->id));
      all.push_back(p->plane_world.offset_m);
      for (const Eigen::Vector3d& v : p->outline_world) all.insert(all.end(), {v.x(), v.y(), v.z()});
    }
    runs.push_back(std::move(all));
  }
  ASSERT_EQ(runs[0].size(), runs[1].size());
  EXPECT_EQ(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(double)), 0);
}

TEST(PolygonMergerTest, SharesPolygonsThatDidNotChange) {
  const PlaneWorld world = StairsWorld();
  Mapper mapper;
  for (int i = 0; i < 3; ++i) mapper.See(world, LookFrom(i, 0.5, 0, 0.9, 0, 0.35));
  const std::vector<PolygonPtr> before = mapper.All();
  ASSERT_FALSE(before.empty());
  // A frame that looks elsewhere.
  const PolygonUpdate after = mapper.See({}, LookFrom(3, 0.5, 0, 0.9, std::numbers::pi, 0));
  EXPECT_TRUE(after.added.empty());
  EXPECT_TRUE(after.revised.empty());
  EXPECT_TRUE(after.removed.empty());
  EXPECT_TRUE(after.changed.empty());
  EXPECT_EQ(before, mapper.All());
}

TEST(PolygonMergerTest, SaysWhatAFrameAddedRevisedRemovedAndSawAgain) {
  PlaneWorld with_box = StairsWorld();
  const PlaneWorld empty = with_box;
  with_box.AddBox(0.6, 0.9, -0.2, 0.2, 0, 0.2);
  Mapper mapper;
  std::map<PolygonId, int> revisions, greatest, observations;
  std::size_t num_added = 0, num_revised = 0, num_removed = 0, num_seen = 0;
  for (int i = 0; i < 40; ++i) {
    const PolygonUpdate& update =
        mapper.See(i < 15 ? with_box : empty, LookFrom(i, 0.2 + 0.01 * std::min(i, 10), 0, 0.9, 0, 0.5));
    for (const PolygonId id : update.added) {
      const int revision = mapper.polygons().Find(id)->revision;
      EXPECT_TRUE(revisions.emplace(id, revision).second) << id;
      EXPECT_GT(revision, greatest[id]) << "it had " << id << " before";
    }
    for (const PolygonId id : update.revised)
      EXPECT_EQ(mapper.polygons().Find(id)->revision, ++revisions.at(id));
    EXPECT_EQ(update.changed.size(), update.added.size() + update.revised.size());
    for (const PolygonPtr& polygon : update.changed) EXPECT_EQ(polygon, mapper.polygons().Find(polygon->id));
    for (const PolygonId id : update.removed) EXPECT_EQ(revisions.erase(id), 1U) << id;
    for (const PolygonId id : update.seen) {
      const PolygonMap::Entry* entry = mapper.polygons().FindEntry(id);
      ASSERT_NE(entry, nullptr);
      EXPECT_EQ(entry->polygon->revision, revisions.at(id));
      EXPECT_EQ(entry->last_seen.ns, update.t_capture.ns);
      EXPECT_GT(entry->num_observations, observations[id]);
    }
    std::map<PolygonId, int> now;
    for (const auto& [id, entry] : mapper.polygons()) {
      now[id] = greatest[id] = entry.polygon->revision;
      observations[id] = entry.num_observations;
    }
    EXPECT_EQ(now, revisions) << "after frame " << i;
    num_added += update.added.size();
    num_revised += update.revised.size();
    num_removed += update.removed.size();
    num_seen += update.seen.size();
  }
  EXPECT_GT(num_added, 3U);
  EXPECT_GT(num_revised, 3U);
  EXPECT_GT(num_removed, 0U);
  EXPECT_GT(num_seen, 3U);
}

TEST(MergingConfigTest, NamesEverySettingThatMakesNoSense) {
  EXPECT_TRUE(MergingConfig{}.Problems().empty());
  EXPECT_TRUE(ModellingConfig{}.Problems().empty());
  MergingConfig config;
  config.max_offset_m = 0.0;
  config.max_angle_deg = 90.0;
  EXPECT_EQ(config.Problems().size(), 2U);
}

}  // namespace
}  // namespace terrace
