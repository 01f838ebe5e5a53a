// SPDX-License-Identifier: BSD-3-Clause
// Each step of dense stereo at 640x480 (the fast tier's at half of it), one thread.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "stereo/census.h"
#include "stereo/cloud.h"
#include "stereo/depth_edges.h"
#include "stereo/disparity_filters.h"
#include "stereo/disparity_matcher.h"
#include "stereo/half_resolution.h"
#include "stereo/refinement.h"
#include "stereo/semi_global.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

const SlantedPlane kPlane{10.0, 0.01, 0.1};
const StereoFrame& Pair(int width, int height) {
  static const StereoFrame full = RenderPlane(640, 480, kPlane);
  static const StereoFrame half = RenderPlane(320, 240, kPlane);
  return width == 640 && height == 480 ? full : half;
}
cv::Mat1f Disparity() {
  cv::Mat1f disparity(480, 640);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) disparity(v, u) = static_cast<float>(kPlane.At(u, v));
  return disparity;
}

const tbb::global_control kOneThread(tbb::global_control::max_allowed_parallelism, 1);

void CensusOfImage(benchmark::State& state) {
  CensusImage census;
  for (auto _ : state) census.Compute(Pair(640, 480).left, Census9x7());
}
BENCHMARK(CensusOfImage)->Unit(benchmark::kMillisecond);

void SemiGlobal(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), num_disparities = static_cast<int>(state.range(1));
  const StereoFrame& pair = Pair(width, width * 3 / 4);
  SemiGlobalMatcher matcher({});
  cv::Mat1f disparity;
  for (auto _ : state) matcher.Match(pair.left, pair.right, num_disparities, disparity);
}
BENCHMARK(SemiGlobal)
    ->Args({640, 64})
    ->Args({640, 128})
    ->Args({320, 32})
    ->Args({320, 64})
    ->Unit(benchmark::kMillisecond);

void Speckles(benchmark::State& state) {
  cv::Mat1f disparity = Disparity();
  for (auto _ : state) RemoveSpeckles(100, 2.0f, disparity);
}
BENCHMARK(Speckles)->Unit(benchmark::kMillisecond);

void DepthEdges(benchmark::State& state) {
  const StereoFrame& pair = Pair(640, 480);
  UnitImage disparity;
  disparity.Set(Disparity());
  DepthEdgeSharpener edges({.rounds = 1});
  for (auto _ : state) edges.Sharpen(pair.left, pair.right, disparity);
}
BENCHMARK(DepthEdges)->Unit(benchmark::kMillisecond);

void Refinement(benchmark::State& state) {
  const StereoFrame& pair = Pair(640, 480);
  cv::Mat1f disparity = Disparity(), sigma;
  Refiner refiner({.iterations = 1});
  for (auto _ : state) refiner.Refine(pair.left, pair.right, disparity, &sigma);
}
BENCHMARK(Refinement)->Unit(benchmark::kMillisecond);

void WholeMatch(benchmark::State& state) {
  DisparityConfig config;
  config.tier = state.range(0) == 0 ? "fast" : "quality";
  config.max_disparity_px = static_cast<int>(state.range(1));
  config.paths = static_cast<int>(state.range(2));
  DisparityMatcher matcher(config);
  for (auto _ : state) benchmark::DoNotOptimize(matcher.Match(Pair(640, 480)));
}
BENCHMARK(WholeMatch)->ArgsProduct({{0, 1}, {64, 128}, {2, 4, 8}})->Unit(benchmark::kMillisecond);

void Triangulation(benchmark::State& state) {
  const StereoCamera camera{640, 480, 400, 400, 319.5, 239.5, 0.12};
  DisparityImage image;
  image.disparity_px = Disparity();
  image.sigma_px = cv::Mat1f(480, 640, 0.1f);
  for (auto _ : state) benchmark::DoNotOptimize(Triangulate(image, camera, {}));
}
BENCHMARK(Triangulation)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrace
