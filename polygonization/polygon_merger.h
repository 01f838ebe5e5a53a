// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "polygonization/cell_modeller.h"
#include "polygonization/merging_config.h"
#include "polygonization/polygon.h"
#include "polygonization/polygon_map.h"

namespace terrace {

/// Keeps the global polygon map: joins patches of neighbouring cells, touches only what changed.
class PolygonMerger {
 public:
  explicit PolygonMerger(const MergingConfig& config);
  ~PolygonMerger();

  PolygonUpdate Merge(const PatchUpdate& patches);

  /// The whole map as it is after the last Merge().
  const PolygonMap& polygons() const;
  std::int64_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
