// SPDX-License-Identifier: BSD-3-Clause
// From cloud to polygons at 640x480: decomposition, modelling and merging of a walk towards a staircase.
#include <numbers>

#include <benchmark/benchmark.h>

#include "polygonization/cell_modeller.h"
#include "polygonization/polygon_merger.h"
#include "stereo/cloud.h"
#include "test/mapping/disparity_of_planes.h"

namespace terrace {
namespace {

constexpr int kNumFrames = 20;

struct Walk {
  StereoCamera camera{640, 480, 400.0, 400.0, 319.5, 239.5, 0.12};
  std::vector<DisparityImage> disparities;
  std::vector<Cloud> clouds;
  std::vector<PoseEstimate> poses;

  Walk() {
    PlaneWorld world;
    world.AddFloor(-1, 2.5, -1, 1, 0);
    world.AddStairs(2.5, -0.7, 0.7, 0.17, 0.28, 6);
    world.rectangles.push_back({{-1, 1, 0}, {0, 0, 2.5}, {6, 0, 0}});
    world.rectangles.push_back({{-1, -1, 0}, {6, 0, 0}, {0, 0, 2.5}});
    std::mt19937 random(1);
    for (int i = 0; i < kNumFrames; ++i) {
      poses.push_back(LookFrom(i, 0.04 * i, 0, 0.5, 0, 20.0 * std::numbers::pi / 180.0));
      disparities.push_back(DisparityOf(world, camera, poses.back(), 0.15F, &random));
      clouds.push_back(Triangulate(disparities.back(), camera, {}));
    }
  }
};

const Walk& TheWalk() {
  static const Walk walk;
  return walk;
}

/// Stages up to the given one, so that differences are the cost of a stage; time per frame.
void BM_Map(benchmark::State& state) {
  const Walk& walk = TheWalk();
  for (auto _ : state) {
    TerrainOctree octree(MappingConfig{});
    CellModeller modeller({});
    PolygonMerger merger({});
    for (int i = 0; i < kNumFrames; ++i) {
      const ChangedCells cells = octree.Insert(walk.clouds[i], walk.camera, walk.poses[i]);
      if (state.range(0) == 1) continue;
      const PatchUpdate patches = modeller.Fit(octree, cells);
      if (state.range(0) == 2) continue;
      benchmark::DoNotOptimize(
          merger.Merge(patches, {walk.camera, walk.poses[i].T_world_left, &walk.disparities[i]}));
    }
  }
  state.counters["points"] = static_cast<double>(walk.clouds.back().points.size());
  state.counters["ms_per_frame"] =
      benchmark::Counter(static_cast<double>(state.iterations() * kNumFrames) / 1e3,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_Map)->Arg(1)->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrace
