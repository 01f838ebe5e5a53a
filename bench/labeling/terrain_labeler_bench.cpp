// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>

#include "label_scene.h"

namespace terrace {
namespace {

/// A ring with many short edges, as outlines of cells have them.
Ring Frayed(const Ring& ring) {
  constexpr double kEdge = 0.05;
  Ring frayed;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector3d& a = ring[i];
    const Eigen::Vector3d& b = ring[(i + 1) % ring.size()];
    const int n = std::max(1, static_cast<int>((b - a).norm() / kEdge));
    for (int k = 0; k < n; ++k) frayed.push_back(a + (b - a) * k / n);
  }
  return frayed;
}

/// Halls with stairs, walls and boxes: about 30 pieces each.
LabelScene Halls(int num_halls) {
  LabelScene scene;
  for (int h = 0; h < num_halls; ++h) {
    const double y = 3.0 * h;
    scene.AddLevel(TerrainLabel::kWalkway, {3, y, 0}, 8, 2);
    scene.AddFace(TerrainLabel::kWall, {-1, y + 1, 0}, {7, y + 1, 0}, 2.6);
    scene.AddFace(TerrainLabel::kWall, {7, y - 1, 0}, {-1, y - 1, 0}, 2.6);
    KnownFlight flight;
    flight.foot = {7, y, 0};
    scene.AddFlight(flight);
    scene.AddLevel(TerrainLabel::kWalkway, {9.9, y, 1.02}, 3, 2);
    for (int b = 0; b < 3; ++b) scene.AddBox({1.5 * b, y + 0.6, 0}, 0.4, 0.4, 0.3 + 0.1 * b, 0.3 * b);
  }
  for (KnownPiece& piece : scene.pieces) piece.outline = Frayed(piece.outline);
  return scene;
}

/// One frame of a walk: the surfaces near the robot have changed, the others have not.
void LabelWhileWalking(benchmark::State& state) {
  const LabelScene scene = Halls(static_cast<int>(state.range(0)));
  const int num_changed = static_cast<int>(state.range(1));
  PolygonUpdate update = scene.Update({0.003, 0.01, 0.005});
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, update, StandingAt(5, 0));
  int frame = 0;
  for (auto _ : state) {
    state.PauseTiming();
    for (int i = 0; i < num_changed; ++i) {
      auto changed = std::make_shared<Polygon>(*update.changed[i]);
      ++changed->revision;
      update.changed[i] = changed;
    }
    ++frame;
    state.ResumeTiming();
    benchmark::DoNotOptimize(labeler.Label(update, StandingAt(5 + 0.001 * (frame % 100), 0), TestGravity()));
  }
  state.counters["regions"] = static_cast<double>(update.changed.size());
}
BENCHMARK(LabelWhileWalking)->Args({3, 25})->Args({6, 25})->Args({6, 0})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace terrace
