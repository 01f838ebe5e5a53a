// SPDX-License-Identifier: BSD-3-Clause
// How much of the treads and floors of replayed maps convex pieces cover, and how many pieces a tread needs.
// Arguments: folders of results. The last line is one JSON object.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>

#include "client/convex_surface.h"
#include "client/inset.h"
#include "client/terrain_query.h"
#include "results/map_file.h"

namespace terrace {
namespace {

constexpr double kInset_m = 0.03;  // a foot's radius
constexpr double kMinArea_m2 = 0.02;
const Eigen::AlignedBox3d kAll(Eigen::Vector3d::Constant(-1e4), Eigen::Vector3d::Constant(1e4));

struct Sums {
  double inset_m2 = 0.0;
  double covered_m2 = 0.0;
  int num_treads = 0;
  int num_pieces_on_treads = 0;
  int most_on_a_tread = 0;
  int num_pieces = 0;
};

void Add(const TerrainQuery& query, Sums* sums) {
  std::map<std::int64_t, std::vector<FlatRing>> pieces;
  for (ConvexSurface& surface : ConvexSurfaces(query, kAll, kInset_m, kMinArea_m2))
    pieces[surface.region_id].push_back(std::move(surface.vertices));
  for (const auto& [id, rings] : pieces) {
    const TerrainQuery::Entry& entry = *query.Find(id);
    const auto inset = entry.shape->Inset({kInset_m, kInset_m, kInset_m});
    sums->inset_m2 += inset->area_m2();
    sums->covered_m2 += inset->area_m2() - Without(*inset, rings).area_m2();
    sums->num_pieces += static_cast<int>(rings.size());
    if (entry.region->label != TerrainLabel::kStairTread) continue;
    ++sums->num_treads;
    sums->num_pieces_on_treads += static_cast<int>(rings.size());
    sums->most_on_a_tread = std::max(sums->most_on_a_tread, static_cast<int>(rings.size()));
  }
}

int Run(int argc, char** argv) {
  Sums sums;
  const std::clock_t start = std::clock();
  for (int i = 1; i < argc; ++i) {
    const auto path = std::filesystem::path(argv[i]) / "terrain_map.json";
    Sums one;
    Add(TerrainQuery(std::make_shared<const TerrainMap>(ReadTerrainMapFile(path))), &one);
    Add(TerrainQuery(std::make_shared<const TerrainMap>(ReadTerrainMapFile(path))), &sums);
    std::printf("%s: %.1f %% of %.1f m2 by %d pieces; %d treads, at most %d pieces on one\n", argv[i],
                100.0 * one.covered_m2 / one.inset_m2, one.inset_m2, one.num_pieces, one.num_treads,
                one.most_on_a_tread);
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / 2.0;
  std::printf(
      "{\"covered_percent\": %.2f, \"pieces_a_tread\": %.2f, \"most_on_a_tread\": %d, \"ms_a_piece\": "
      "%.2f}\n",
      100.0 * sums.covered_m2 / sums.inset_m2,
      static_cast<double>(sums.num_pieces_on_treads) / std::max(1, sums.num_treads), sums.most_on_a_tread,
      1e3 * seconds / std::max(1, sums.num_pieces));
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) { return terrace::Run(argc, argv); }
