// SPDX-License-Identifier: BSD-3-Clause
// What a frame costs as the map grows:
//     terrace_map_growth SEQUENCE [NUM_FRAMES [NUM_PLACES [STRIDE]]]
// matches and tracks the first frames of a recording once, then shows them (or one in STRIDE of them: so
// large maps are reached in reasonable time) to the mapper again and again at places 14 m apart on a grid
// (disparities and poses kept, poses shifted), as to a robot that walks through one such room after the
// other. A row every so many places: mapped area, CPU time per frame of each stage, memory, regions. The last
// line is one JSON object:
//  - cpu_ratio: CPU per frame of all map stages and publishing, the last tenth of the places against places 5
//    to 10;
//  - p99_over_median: of one frame's CPU, over the last half of the places;
//  - window_kb_per_m2: growth of the map's memory from place to place, by what was mapped there, where all of
//    it lies within the window (of another map with a very large one, which is shown all frames);
//  - window_mb: the most memory that the map ever had;
//  - beyond_kb_per_m2: growth of the map's memory over the last half of the places, by what was mapped there;
//  - heap_beyond_kb_per_m2: the same of all that the program has allocated, labels and messages included.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <vector>

#include <malloc.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "bench/terrain/shots.h"
#include "core/statistics.h"
#include "daemon/pipeline.h"
#include "daemon/terrain_sender.h"
#include "datasets/sequence.h"
#include "terrain/terrain_mapper.h"

namespace terrace {
namespace {

constexpr double kSpacing_m = 14.0;
constexpr int kPlacesPerRow = 24;
constexpr int kTableRows = 20;
constexpr std::array kMapStages{StageId::kDecomposition, StageId::kModelling, StageId::kMerging,
                                StageId::kLabels, StageId::kPublish};

/// Places on a grid, row by row, there and back.
Eigen::Vector3d PlaceAt(int i) {
  const int row = i / kPlacesPerRow, column = i % kPlacesPerRow;
  return kSpacing_m * Eigen::Vector3d(row % 2 == 0 ? column : kPlacesPerRow - 1 - column, row, 0);
}

double MappedArea(const TerrainMap& map) {
  double area_m2 = 0.0;
  for (const auto& region : map.regions) area_m2 += region->area_m2;
  return area_m2;
}

/// What one place led to.
struct Place {
  double cpu_ms = 0.0;  ///< per frame, of all map stages and publishing
  double area_m2 = 0.0;
  double map_mb = 0.0;
  double heap_mb = 0.0;
  std::size_t num_regions = 0;
};

/// Shows the same frames to one mapper at one place after the other.
class GrowingMap {
 public:
  GrowingMap(const std::vector<Shot>& shots, const Pipeline& pipeline, const TerrainConfig& config)
      : shots_(shots),
        camera_(pipeline.camera()),
        mapper_(config, camera_, pipeline.T_body_left(), &meters_),
        sender_(pipeline.T_body_left(), std::chrono::seconds(60), 0) {}

  Place Visit(const Eigen::Vector3d& place_world, std::vector<double>* frames_ms) {
    Place place;
    MapChange change;
    for (const Shot& shot : shots_) {
      PoseEstimate pose = shot.pose;
      pose.T_world_left.translation() += place_world;
      pose.frame_id = frame_id_++;
      pose.t_capture = shots_.front().pose.t_capture + std::chrono::milliseconds(66 * pose.frame_id);
      DisparityImage disparity = *shot.disparity;  // shares the pixels
      disparity.frame_id = pose.frame_id;
      disparity.t_capture = pose.t_capture;
      const std::int64_t start_ns = ThreadCpuNs();
      change = mapper_.Update({disparity, camera_, cv::Mat1b()}, pose, shot.gravity);
      {
        const StageMeasurement measuring(&meters_, StageId::kPublish);
        sender_.Update(change, std::chrono::steady_clock::now());
      }
      frames_ms->push_back(1e-6 * static_cast<double>(ThreadCpuNs() - start_ns));
      place.cpu_ms += frames_ms->back() / static_cast<double>(shots_.size());
    }
    place.area_m2 = MappedArea(*change.map);
    place.map_mb = 1e-6 * static_cast<double>(change.map_bytes);
    const struct mallinfo2 heap = mallinfo2();
    place.heap_mb = 1e-6 * static_cast<double>(heap.uordblks + heap.hblkhd);
    place.num_regions = change.map->regions.size();
    return place;
  }

  /// CPU per frame of the map's stages since the last call.
  std::vector<double> TakeStagesMs() {
    const std::vector<StageCost> costs = meters_.costs();
    std::vector<double> ms;
    for (const StageId stage : kMapStages) {
      const auto s = static_cast<std::size_t>(stage);
      const auto total = [s](const std::vector<StageCost>& all) {
        return all.empty() ? 0.0 : all[s].cpu_ms_mean * static_cast<double>(all[s].count);
      };
      const auto count = costs[s].count - (costs_.empty() ? 0 : costs_[s].count);
      ms.push_back((total(costs) - total(costs_)) / static_cast<double>(std::max<std::int64_t>(1, count)));
    }
    costs_ = costs;
    return ms;
  }

 private:
  const std::vector<Shot>& shots_;
  const StereoCamera camera_;
  StageMeters meters_;
  TerrainMapper mapper_;
  TerrainSender sender_;
  FrameId frame_id_ = 0;
  std::vector<StageCost> costs_;
};

double MeanMs(const std::vector<Place>& places, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) sum += places[i].cpu_ms;
  return sum / static_cast<double>(end - begin);
}

/// Where nothing is ever folded away.
double WindowKbPerM2(const std::vector<Shot>& shots, const Pipeline& pipeline) {
  constexpr int kPlaces = 6;
  TerrainConfig config;
  config.mapping.window_m = kPlaces * kSpacing_m;
  GrowingMap map(shots, pipeline, config);
  std::vector<Place> places;
  std::vector<double> frames_ms;
  for (int i = 0; i < kPlaces; ++i) places.push_back(map.Visit(PlaceAt(i), &frames_ms));
  const Place &second = places[1], &last = places.back();
  return 1e3 * (last.map_mb - second.map_mb) / (last.area_m2 - second.area_m2);
}

void PrintFigures(const std::vector<Place>& places, const std::vector<double>& frames_ms,
                  double window_kb_per_m2) {
  const std::size_t n = places.size(), early = std::min<std::size_t>(4, n - 1);
  const std::vector<double> late_ms(frames_ms.begin() + static_cast<std::ptrdiff_t>(frames_ms.size() / 2),
                                    frames_ms.end());
  const Place &half = places[n / 2], &last = places.back();
  const auto most = std::max_element(places.begin(), places.end(),
                                     [](const Place& a, const Place& b) { return a.map_mb < b.map_mb; });
  const nlohmann::ordered_json json = {
      {"mapped_m2", last.area_m2},
      {"cpu_ratio", MeanMs(places, n - std::max<std::size_t>(1, n / 10), n) /
                        MeanMs(places, early, std::min(n, early + 6))},
      {"p99_over_median", Quantile(late_ms, 0.99) / Quantile(late_ms, 0.5)},
      {"window_kb_per_m2", window_kb_per_m2},
      {"window_mb", most->map_mb},
      {"beyond_kb_per_m2", 1e3 * (last.map_mb - half.map_mb) / (last.area_m2 - half.area_m2)},
      {"heap_beyond_kb_per_m2", 1e3 * (last.heap_mb - half.heap_mb) / (last.area_m2 - half.area_m2)}};
  std::printf("%s\n", json.dump().c_str());
}

int Run(const char* path, int num_frames, int num_places, int stride) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const std::unique_ptr<Sequence> sequence = OpenSequence(path);
  Pipeline pipeline({}, sequence->info().calibration, {});
  const std::vector<Shot> shots = ShootFrames(sequence.get(), &pipeline, num_frames);
  if (shots.empty() || num_places < 1) {
    std::fprintf(stderr, "%s: no frame can be mapped\n", path);
    return 1;
  }
  const double window_kb_per_m2 = WindowKbPerM2(shots, pipeline);
  const std::vector<Shot> some = OneIn(std::max(1, stride), shots);
  GrowingMap growing(some, pipeline, {});
  std::vector<Place> places;
  std::vector<double> frames_ms;
  std::printf("   m2  decomposition modelling merging   labels  publish     all ms   map MB  regions\n");
  for (int i = 0; i < num_places; ++i) {
    places.push_back(growing.Visit(PlaceAt(i), &frames_ms));
    if ((i + 1) % std::max(1, num_places / kTableRows) != 0) continue;
    std::printf("%5.0f     ", places.back().area_m2);
    for (const double ms : growing.TakeStagesMs()) std::printf(" %8.2f", ms);
    std::printf("   %8.2f %8.1f %8zu\n", places.back().cpu_ms, places.back().map_mb,
                places.back().num_regions);
    std::fflush(stdout);
  }
  PrintFigures(places, frames_ms, window_kb_per_m2);
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 5) {
    std::fprintf(stderr, "usage: terrace_map_growth SEQUENCE [NUM_FRAMES [NUM_PLACES [STRIDE]]]\n");
    return 2;
  }
  try {
    return terrace::Run(argv[1], argc > 2 ? std::atoi(argv[2]) : 60, argc > 3 ? std::atoi(argv[3]) : 40,
                        argc > 4 ? std::atoi(argv[4]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
