// SPDX-License-Identifier: BSD-3-Clause
// What questions to a map of 5,000 ragged regions cost, in CPU time of one thread. The last line is one JSON
// object.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <vector>

#include "client/terrain_query.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr int kNumRegions = 5000;
constexpr int kNumVertices = 100;  // as maps of real places have
constexpr double kHalfExtent_m = 25.0;

double CpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Median CPU time of several rounds [s], each of `count` calls; per call.
double MedianSeconds(int rounds, int count, const std::function<void(int)>& call) {
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const double start = CpuSeconds();
    for (int i = 0; i < count; ++i) call(i);
    times.push_back((CpuSeconds() - start) / count);
  }
  std::nth_element(times.begin(), times.begin() + rounds / 2, times.end());
  return times[static_cast<std::size_t>(rounds / 2)];
}

/// A floor under everything, with an outline of 3,000 edges.
std::shared_ptr<TerrainRegion> Floor(ScatteredTerrain* terrain) {
  return MadeRegion(kNumRegions + 1, TerrainLabel::kWalkway, LevelAt(-0.1),
                    terrain->Ragged({0, 0}, 1.5 * kHalfExtent_m, 3000));
}

/// The map after a frame that changed ten regions.
TerrainMapPtr WithTenChanged(const TerrainMap& map, ScatteredTerrain* terrain) {
  auto next = std::make_shared<TerrainMap>(map);
  ++next->seq;
  for (int i = 0; i < 10; ++i) {
    auto& region = next->regions[static_cast<std::size_t>(terrain->Int(0, kNumRegions - 1))];
    auto changed = terrain->Region(region->id, kHalfExtent_m, kNumVertices);
    changed->revision = region->revision + 1;
    region = changed;
  }
  return next;
}

int Run() {
  ScatteredTerrain terrain(1);
  auto map = terrain.Map(kNumRegions, kHalfExtent_m, kNumVertices);
  map->regions.push_back(Floor(&terrain));
  std::unique_ptr<TerrainQuery> query;
  const double build_s = MedianSeconds(5, 1, [&](int) { query = std::make_unique<TerrainQuery>(map); });

  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 2000; ++i)
    places.emplace_back(terrain.Real(-20, 20), terrain.Real(-20, 20), terrain.Real(0, 1.5));
  const auto at = [&](int i) -> const Eigen::Vector3d& { return places[static_cast<std::size_t>(i)]; };
  std::size_t num_found = 0;
  const double support_s = MedianSeconds(
      9, 2000, [&](int i) { num_found += query->SupportAt(at(i).head<2>(), -1.0, 3.0).has_value(); });
  const auto foothold = [&](int i) { num_found += query->NearestFoothold(at(i), 0.3, 0.3).has_value(); };
  const double first_foothold_s = MedianSeconds(1, 2000, foothold);
  const double foothold_s = MedianSeconds(9, 2000, foothold);
  HeightGridSpec spec;
  const double heights_s = MedianSeconds(9, 20, [&](int i) {
    spec.first_xy = at(i).head<2>();
    num_found += query->Heights(spec).at(50, 50).known();
  });

  std::vector<double> updates;
  for (int i = 0; i < 20; ++i) {
    const TerrainMapPtr next = WithTenChanged(query->map(), &terrain);
    const double start = CpuSeconds();
    auto updated = std::make_unique<TerrainQuery>(next, query.get());
    query = std::move(updated);
    updates.push_back(CpuSeconds() - start);
  }
  std::nth_element(updates.begin(), updates.begin() + 10, updates.end());

  std::printf("%d regions of %d vertices and a floor of 3,000; %zu answers\n", kNumRegions, kNumVertices,
              num_found);
  std::printf(
      "{\"support_at_us\": %.2f, \"nearest_foothold_us\": %.2f, \"nearest_foothold_first_us\": %.2f, "
      "\"heights_100x100_ms\": %.3f, \"update_of_ten_ms\": %.3f, \"build_ms\": %.1f}\n",
      1e6 * support_s, 1e6 * foothold_s, 1e6 * first_foothold_s, 1e3 * heights_s, 1e3 * updates[10],
      1e3 * build_s);
  return 0;
}

}  // namespace
}  // namespace terrace

int main() { return terrace::Run(); }
