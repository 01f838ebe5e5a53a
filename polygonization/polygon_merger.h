// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "polygonization/cell_modeller.h"
#include "polygonization/polygon.h"

namespace terrace {

/// Settings of merging patches into polygons. YAML section: `merging`.
struct MergingConfig {
  /// Neighbouring patches within this offset and angle are one surface.
  double max_offset_m = 0.03;
  double max_angle_deg = 10.0;
  /// Polygons smaller than this are not published.
  double min_area_m2 = 0.01;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Keeps the global polygon map: joins patches of neighbouring cells, touches only what changed.
class PolygonMerger {
 public:
  explicit PolygonMerger(const MergingConfig& config);
  ~PolygonMerger();

  PolygonUpdate Merge(const PatchUpdate& update);

  std::int64_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
