// SPDX-License-Identifier: BSD-3-Clause
// Writes a log of terrain messages and, as LOG.terrace, the map that it ends with, as LOG.octree an
// octree_v1_t, and prints as JSON what a C++ subscriber has of it and how TerrainQuery answers: what the
// Python package is held against.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <lcm/lcm-cpp.hpp>

#include "client/occupied_space.h"
#include "client/terrace_file.h"
#include "client/terrain_follower.h"
#include "client/terrain_query.h"
#include "core/file_bytes.h"
#include "lcmtypes/terrain_codec.h"
#include "mapping/octomap_bytes.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr double kHalfExtent_m = 2.0;
constexpr std::size_t kPartBytes = 1400;

void Write(lcm::LogFile* log, TerrainFollower* follower, const std::vector<terrain_v1_t>& messages) {
  for (const terrain_v1_t& message : messages) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    lcm::LogEvent event{};
    event.timestamp = message.utime;
    event.channel = "TERRACE_TERRAIN";
    event.datalen = static_cast<std::int32_t>(bytes.size());
    event.data = bytes.data();
    log->writeEvent(&event);
    follower->Receive(bytes.data(), bytes.size());
  }
}

void PrintRegions(const TerrainMap& map) {
  std::printf("{\"seq\": %ld, \"regions\": [", static_cast<long>(map.seq));
  const char* comma = "";
  for (const auto& region : map.regions) {
    const Eigen::Vector3d& first = region->outline_world.front();
    std::printf(
        "%s{\"id\": %ld, \"revision\": %d, \"label\": \"%s\", \"confidence\": %.9g, \"vertices\": %zu, "
        "\"first\": [%.9f, %.9f, %.9f], \"last_seen_ns\": %ld}",
        comma, static_cast<long>(region->id), region->revision, Name(region->label), region->confidence,
        region->edges.size(), first.x(), first.y(), first.z(), static_cast<long>(region->last_seen.ns));
    comma = ", ";
  }
  std::printf("],\n");
}

void PrintSupport(const Support& support) {
  const Eigen::Vector3d& p = support.point_world;
  std::printf(
      "{\"region\": %ld, \"point\": [%.9f, %.9f, %.9f], \"sigma\": %.9g, \"edge_distance\": %.9f, "
      "\"edge\": \"%s\", \"age\": %.9f}",
      static_cast<long>(support.region_id), p.x(), p.y(), p.z(), support.sigma_height_m,
      support.edge_distance_m, Name(support.edge.kind), support.age_s);
}

/// Leaves all over the place, of which some lie on regions.
octree_v1_t ScatteredOctree(const TerrainQuery& query, ScatteredTerrain* terrain) {
  constexpr double kLeaf_m = 0.02;
  std::vector<OccupiedLeaf> leaves;
  for (int i = 0; i < 300; ++i) {
    const auto at = [&](double low, double high) {
      return 4 * static_cast<int>(std::lround(terrain->Real(low, high) / (4 * kLeaf_m)));
    };
    leaves.push_back(
        {{at(-kHalfExtent_m, kHalfExtent_m), at(-kHalfExtent_m, kHalfExtent_m), at(-0.2, 2.0)}, i % 3, 1});
  }
  octree_v1_t message{};
  message.map_id = query.map().map_id;
  message.encoding = octree_v1_t::OCTOMAP_OT;
  for (int axis = 0; axis < 3; ++axis) {
    message.box_min[axis] = -1.5;
    message.box_max[axis] = 2.5;
  }
  message.data = OctomapBytes(leaves, kLeaf_m, OctomapFormat::kOt);
  message.n_bytes = static_cast<std::int32_t>(message.data.size());
  return message;
}

void PrintAnswers(const TerrainQuery& query, const OccupiedSpace& space, ScatteredTerrain* terrain) {
  std::printf("\"supports\": [");
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d xy(terrain->Real(-kHalfExtent_m, kHalfExtent_m),
                             terrain->Real(-kHalfExtent_m, kHalfExtent_m));
    std::printf("%s{\"xy\": [%.17g, %.17g], \"found\": [", i > 0 ? ",\n" : "", xy.x(), xy.y());
    const char* comma = "";
    for (const Support& support : query.SupportsAt(xy)) {
      std::printf("%s", comma);
      PrintSupport(support);
      comma = ", ";
    }
    std::printf("]}");
  }
  std::printf("],\n\"footholds\": [");
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d nominal(terrain->Real(-kHalfExtent_m, kHalfExtent_m),
                                  terrain->Real(-kHalfExtent_m, kHalfExtent_m), terrain->Real(-0.2, 1.7));
    const auto foothold = query.NearestFoothold(nominal, 0.3, 0.3);
    std::printf("%s{\"nominal\": [%.17g, %.17g, %.17g], \"distance\": ", i > 0 ? ",\n" : "", nominal.x(),
                nominal.y(), nominal.z());
    if (foothold) std::printf("%.9f}", foothold->distance_m);
    if (!foothold) std::printf("null}");
  }
  std::printf("],\n\"clearances\": [");
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d a(terrain->Real(-kHalfExtent_m, kHalfExtent_m),
                            terrain->Real(-kHalfExtent_m, kHalfExtent_m), terrain->Real(-0.2, 2.0));
    const Eigen::Vector3d b =
        a + 0.4 * Eigen::Vector3d(terrain->Real(-1, 1), terrain->Real(-1, 1), terrain->Real(-1, 1));
    // Every second one without the octree.
    const Clearance clearance = query.CapsuleClearance(a, b, 0.04, kAllLabels, i % 2 == 0 ? &space : nullptr);
    const Eigen::Vector3d& g = clearance.gradient_world;
    std::printf(
        "%s{\"a\": [%.17g, %.17g, %.17g], \"b\": [%.17g, %.17g, %.17g], \"distance\": %.9f, "
        "\"gradient\": [%.9f, %.9f, %.9f], \"region\": %ld, \"occupancy\": %d}",
        i > 0 ? ",\n" : "", a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), clearance.distance_m, g.x(), g.y(),
        g.z(), static_cast<long>(clearance.region_id), static_cast<int>(clearance.occupancy));
  }
  std::printf("]}\n");
}

int Run(const std::string& path) {
  ScatteredTerrain terrain(7);
  const auto first = terrain.Map(40, kHalfExtent_m);
  TerrainMap second = *first;
  ++second.seq;
  second.regions.erase(second.regions.begin() + 10);
  for (std::size_t i = 20; i < 25; ++i) {
    auto changed = terrain.Region(second.regions[i]->id, kHalfExtent_m);
    changed->revision = 2;
    second.regions[i] = changed;
  }
  TerrainMap later = second;
  later.t_capture.ns += 500'000'000;
  lcm::LogFile log(path, "w");
  if (!log.good()) return 1;
  TerrainFollower follower;
  Write(&log, &follower, SnapshotMessages(*first, kPartBytes));
  Write(&log, &follower, DeltaMessages(*first, second, kPartBytes));
  const SeenRegion seen{second.regions[0]->id, later.t_capture - std::chrono::milliseconds(20)};
  Write(&log, &follower, SeenMessages(later, std::nullopt, {&seen, 1}, kPartBytes));
  // With views, which say nothing of the regions.
  std::vector<PlaceView> views(2);
  views.front().corners.resize(50);
  SaveTerraceFile(path + ".terrace", *follower.map(), views);
  PrintRegions(*follower.map());
  const TerrainQuery query(follower.map());
  const octree_v1_t octree = ScatteredOctree(query, &terrain);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(octree.getEncodedSize()));
  octree.encode(bytes.data(), 0, octree.getEncodedSize());
  WriteFileBytes(path + ".octree", bytes);
  PrintAnswers(query, OccupiedSpace(octree, query), &terrain);
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) { return argc == 2 ? terrace::Run(argv[1]) : 2; }
