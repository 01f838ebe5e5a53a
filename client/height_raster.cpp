// SPDX-License-Identifier: BSD-3-Clause
#include "client/height_raster.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/check.h"

namespace terrace {
namespace {

/// Where the outlines of a region cross the middles of columns of cells: by column, y over the ground [m].
using Crossings = std::vector<std::vector<double>>;

void AddCrossings(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const HeightGridSpec& spec,
                  Crossings* crossings) {
  const Eigen::Vector2d& left = a.x() <= b.x() ? a : b;
  const Eigen::Vector2d& right = a.x() <= b.x() ? b : a;
  const double first = std::ceil((left.x() - spec.first_xy.x()) / spec.cell_m);
  for (int i = static_cast<int>(std::clamp(first - 1.0, 0.0, static_cast<double>(spec.num_x)));
       i < spec.num_x; ++i) {
    const double x = spec.first_xy.x() + spec.cell_m * i;
    if (x >= right.x()) break;
    // Half open, so that a vertex on a column counts once.
    if (x < left.x()) continue;
    const double y = left.y() + (x - left.x()) / (right.x() - left.x()) * (right.y() - left.y());
    (*crossings)[static_cast<std::size_t>(i)].push_back(y);
  }
}

/// One region into the grid.
class Filler {
 public:
  Filler(const TerrainQuery& query, const TerrainQuery::Entry& entry, HeightGrid* grid)
      : entry_(entry), spec_(grid->spec), grid_(grid) {
    value_.age_s = static_cast<float>(query.AgeSeconds(*entry.region));
    value_.label = entry.region->label;
    value_.predicted = entry.region->predicted();
    value_.region_id = entry.region->id;
  }

  void Fill(Crossings* crossings) {
    const FlatPolygon& polygon = entry_.shape->polygon();
    for (std::size_t e = 0; e < polygon.num_edges(); ++e) {
      AddCrossings(entry_.shape->ToWorld(polygon.start(e)).head<2>(),
                   entry_.shape->ToWorld(polygon.end(e)).head<2>(), spec_, crossings);
    }
    for (int i = 0; i < spec_.num_x; ++i) {
      std::vector<double>& ys = (*crossings)[static_cast<std::size_t>(i)];
      std::sort(ys.begin(), ys.end());
      for (std::size_t k = 0; k + 1 < ys.size(); k += 2) FillColumn(i, ys[k], ys[k + 1]);
      ys.clear();
    }
  }

 private:
  void FillColumn(int i, double from_y, double to_y) {
    const auto cell = [&](double y) { return (y - spec_.first_xy.y()) / spec_.cell_m; };
    const int begin = static_cast<int>(std::ceil(std::clamp(cell(from_y), 0.0, 1.0 * spec_.num_y)));
    const int end = static_cast<int>(std::ceil(std::clamp(cell(to_y), 0.0, 1.0 * spec_.num_y)));
    for (int j = begin; j < end; ++j) Set(i, j);
  }

  void Set(int i, int j) {
    const Eigen::Vector2d xy = spec_.first_xy + spec_.cell_m * Eigen::Vector2d(i, j);
    const double z = entry_.shape->HeightAt(xy);
    if (!(z >= spec_.z_min && z <= spec_.z_max)) return;
    HeightCell& cell = grid_->cells[static_cast<std::size_t>(i) * static_cast<std::size_t>(spec_.num_y) +
                                    static_cast<std::size_t>(j)];
    const float height_m = static_cast<float>(z);
    // Regions come by ascending id: of equally high ones the lower id stays.
    if (cell.known() && cell.height_m >= height_m) return;
    cell = value_;
    cell.height_m = height_m;
    cell.sigma_m = static_cast<float>(entry_.shape->SigmaHeight(entry_.shape->ToPlane({xy.x(), xy.y(), z})));
  }

  const TerrainQuery::Entry& entry_;
  const HeightGridSpec& spec_;
  HeightGrid* const grid_;
  HeightCell value_;
};

}  // namespace

HeightGrid RasterHeights(const TerrainQuery& query, const HeightGridSpec& spec) {
  TERRACE_CHECK(spec.cell_m > 0.0 && spec.num_x > 0 && spec.num_y > 0, spec.cell_m, spec.num_x, spec.num_y);
  HeightGrid grid{spec, std::vector<HeightCell>(static_cast<std::size_t>(spec.num_x) *
                                                static_cast<std::size_t>(spec.num_y))};
  const Eigen::Vector2d last_xy =
      spec.first_xy + spec.cell_m * Eigen::Vector2d(spec.num_x - 1, spec.num_y - 1);
  std::vector<std::uint32_t> found;
  query.tree().ForEach(
      [&](const Eigen::AlignedBox3d& box) {
        return (box.min().head<2>().array() <= last_xy.array()).all() &&
               (box.max().head<2>().array() >= spec.first_xy.array()).all() && box.min().z() <= spec.z_max &&
               box.max().z() >= spec.z_min;
      },
      [&](std::size_t i) { found.push_back(query.order()[i]); });
  std::sort(found.begin(), found.end());
  Crossings crossings(static_cast<std::size_t>(spec.num_x));
  for (const std::uint32_t i : found) {
    const TerrainQuery::Entry& entry = query.entries()[i];
    if (!entry.shape->carries() || !spec.labels.Has(entry.region->label)) continue;
    Filler(query, entry, &grid).Fill(&crossings);
  }
  return grid;
}

}  // namespace terrace
