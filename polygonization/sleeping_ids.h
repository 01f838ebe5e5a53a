// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/plane_rings.h"
#include "core/time.h"
#include "polygonization/polygon.h"

namespace terrace {

/// The ids of polygons that went, and where they lay: small ones come and go, as they are seen from nearby
/// and from afar. One that is found where another lay is the same piece of the world, and takes up its id.
class SleepingIds {
 public:
  /// What a polygon that comes back goes on from.
  struct Past {
    PolygonId id = 0;
    int num_observations = 0;
    Timestamp first_seen;
  };
  /// So many are kept; the first that fell asleep are forgotten.
  static constexpr std::size_t kMost = 1024;

  /// @param num_observations  frames that showed it, changed or not
  void Sleep(const Polygon& polygon, int num_observations);
  /// The oldest of those that have most area in common with a polygon, or nearly as much: it sleeps no
  /// longer. Nothing when none lay in its plane and had a fair share of the smaller of the two in common.
  std::optional<Past> Wake(const Polygon& polygon);

  std::size_t size() const { return sleepers_.size(); }
  std::int64_t memory_bytes() const { return bytes_; }

 private:
  struct Sleeper {
    Past past;
    Plane plane_world;
    Eigen::Vector3d centroid_world;
    PlaneAxes axes;
    Ring2 outline;  ///< about the centroid, along the axes
    Eigen::AlignedBox3d box_world;
  };
  using Sleepers = std::map<std::int64_t, Sleeper>;  // in the order in which they fell asleep

  static double AreaInCommon(const Sleeper& sleeper, const Ring2& outline);
  static std::int64_t BytesOf(const Sleeper& sleeper);
  void Erase(Sleepers::iterator at);

  Sleepers sleepers_;
  std::int64_t next_turn_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace terrace
