// SPDX-License-Identifier: BSD-3-Clause
// Whether a map stays the same map when its robot walks to and fro in it:
//     terrace_there_and_back SEQUENCE [NUM_FRAMES [STRIDE]]
// matches and tracks the first frames of a recording once, then shows them to one mapper forwards and
// backwards, three times, with fresh stamps and the poses that each frame has. A row for each time there and
// back; the last line is one JSON object:
//  - ids_survived, area_survived: of the regions that were seen by the end of the first time, the share whose
//    ids are there after the third; the same by area;
//  - regions_ratio: regions after the third time, by those after the first;
//  - double_surfaces: pairs of regions after the third time that face the same way and lie over each other,
//    closer than a step, for more than a fifth of the smaller one.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <memory>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/terrain/shots.h"
#include "evaluation/planar_shape.h"
#include "terrain/terrain_mapper.h"

namespace terrace {
namespace {

constexpr int kTimes = 3;
constexpr double kSameHeight_m = 0.04;
constexpr double kSameWay_rad = 0.2;
constexpr double kCell_m = 0.05;
constexpr double kShareInCommon = 0.2;

/// Shows frames to one mapper, each as a new one.
class Walk {
 public:
  explicit Walk(const Pipeline& pipeline)
      : camera_(pipeline.camera()), mapper_(TerrainConfig{}, camera_, pipeline.T_body_left(), &meters_) {}

  void See(const Shot& shot) {
    PoseEstimate pose = shot.pose;
    pose.frame_id = frame_id_++;
    pose.t_capture = Timestamp{1'000'000'000} + std::chrono::milliseconds(66 * pose.frame_id);
    DisparityImage disparity = *shot.disparity;  // shares the pixels
    disparity.frame_id = pose.frame_id;
    disparity.t_capture = pose.t_capture;
    mapper_.Update({disparity, camera_, cv::Mat1b()}, pose, shot.gravity);
  }
  TerrainMapPtr map() const { return mapper_.map(); }

 private:
  const StereoCamera camera_;
  StageMeters meters_;
  TerrainMapper mapper_;
  FrameId frame_id_ = 0;
};

std::map<std::int64_t, double> AreasById(const TerrainMap& map) {
  std::map<std::int64_t, double> areas_m2;
  for (const auto& region : map.regions)
    if (!region->predicted()) areas_m2[region->id] = region->area_m2;
  return areas_m2;
}

/// Area of one that lies over the other, close to it.
double AreaInCommon(const PlanarShape& a, const PlanarShape& b) {
  double area_m2 = 0.0;
  a.ForEachCell(kCell_m, [&](const Eigen::Vector3d& p) {
    if (std::abs(b.plane().SignedDistance(p)) < kSameHeight_m && b.LiesOver(p)) area_m2 += kCell_m * kCell_m;
  });
  return area_m2;
}

int NumDoubleSurfaces(const TerrainMap& map) {
  struct Seen {
    PlanarShape shape;
    double area_m2;
    Eigen::AlignedBox3d box;
  };
  std::vector<Seen> seen;
  for (const auto& region : map.regions) {
    if (region->predicted()) continue;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : region->outline_world) box.extend(p);
    seen.push_back(
        {PlanarShape(region->plane_world, region->outline_world, region->holes_world), region->area_m2, box});
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.area_m2 < b.area_m2; });
  int num = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      const Plane &a = seen[i].shape.plane(), &b = seen[j].shape.plane();
      if (!seen[i].box.intersects(seen[j].box) || a.normal.dot(b.normal) < std::cos(kSameWay_rad)) continue;
      num += AreaInCommon(seen[i].shape, seen[j].shape) > kShareInCommon * seen[i].area_m2;
    }
  }
  return num;
}

void PrintFigures(const TerrainMap& first, const TerrainMap& last) {
  const std::map<std::int64_t, double> before = AreasById(first), after = AreasById(last);
  double area_m2 = 0.0, survived_m2 = 0.0;
  int num_survived = 0;
  for (const auto& [id, id_area_m2] : before) {
    area_m2 += id_area_m2;
    if (!after.contains(id)) continue;
    survived_m2 += id_area_m2;
    ++num_survived;
  }
  const nlohmann::ordered_json json = {
      {"regions", before.size()},
      {"ids_survived", num_survived / static_cast<double>(before.size())},
      {"area_survived", survived_m2 / area_m2},
      {"regions_ratio", static_cast<double>(after.size()) / static_cast<double>(before.size())},
      {"double_surfaces", NumDoubleSurfaces(last)}};
  std::printf("%s\n", json.dump().c_str());
}

int Run(const char* path, int num_frames, int stride) {
  const std::unique_ptr<Sequence> sequence = OpenSequence(path);
  Pipeline pipeline({}, sequence->info().calibration, {});
  const std::vector<Shot> shots =
      OneIn(std::max(1, stride), ShootFrames(sequence.get(), &pipeline, num_frames));
  if (shots.empty()) {
    std::fprintf(stderr, "%s: no frame can be mapped\n", path);
    return 1;
  }
  Walk walk(pipeline);
  TerrainMapPtr first;
  std::printf("regions  doubles\n");
  for (int time = 0; time < kTimes; ++time) {
    for (const Shot& shot : shots) walk.See(shot);
    for (auto shot = shots.rbegin(); shot != shots.rend(); ++shot) walk.See(*shot);
    if (time == 0) first = walk.map();
    std::printf("%7zu  %7d\n", AreasById(*walk.map()).size(), NumDoubleSurfaces(*walk.map()));
    std::fflush(stdout);
  }
  PrintFigures(*first, *walk.map());
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: terrace_there_and_back SEQUENCE [NUM_FRAMES [STRIDE]]\n");
    return 2;
  }
  try {
    return terrace::Run(argv[1], argc > 2 ? std::atoi(argv[2]) : 100000, argc > 3 ? std::atoi(argv[3]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
