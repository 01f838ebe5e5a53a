// SPDX-License-Identifier: BSD-3-Clause
#include "client/inset.h"

#include <algorithm>
#include <cmath>

#include <polyclipping/clipper.hpp>

namespace terrace {
namespace {

using ClipperLib::Path;
using ClipperLib::Paths;

// Clipper counts in whole numbers: micrometres.
constexpr double kUnitsPerMetre = 1e6;
// Arcs become chords, which cut in by at most this; the margin grows by as much, so that none is cut short.
constexpr double kArcTolerance_m = 0.5e-3;
// Clipper rounds the number of chords of an arc, so that one may span half as much again as its tolerance
// means, and cuts in by the square of that.
constexpr double kClippersTolerance = kArcTolerance_m / (1.5 * 1.5) * kUnitsPerMetre;

ClipperLib::IntPoint ToUnits(const Eigen::Vector2d& p) {
  return {std::llround(p.x() * kUnitsPerMetre), std::llround(p.y() * kUnitsPerMetre)};
}

Paths ToUnits(const std::vector<FlatRing>& rings) {
  Paths paths;
  for (const FlatRing& ring : rings) {
    Path& path = paths.emplace_back();
    for (const Eigen::Vector2d& p : ring) path.push_back(ToUnits(p));
  }
  return paths;
}

FlatPolygon FromUnits(const Paths& paths) {
  std::vector<FlatRing> rings;
  for (const Path& path : paths) {
    FlatRing& ring = rings.emplace_back();
    for (const auto& p : path) {
      ring.emplace_back(static_cast<double>(p.X) / kUnitsPerMetre, static_cast<double>(p.Y) / kUnitsPerMetre);
    }
  }
  return FlatPolygon(std::move(rings));
}

/// The edges of one kind, neighbours joined.
Paths ChainsOf(const FlatPolygon& polygon, const std::vector<RegionEdge>& edges, EdgeKind kind) {
  Paths chains;
  std::size_t first = 0;
  for (const FlatRing& ring : polygon.rings()) {
    bool goes_on = false;
    for (std::size_t i = first; i < first + ring.size(); ++i) {
      const bool counts = edges[i].kind == kind;
      if (counts && !goes_on) chains.push_back({ToUnits(polygon.start(i))});
      if (counts) chains.back().push_back(ToUnits(polygon.end(i)));
      goes_on = counts;
    }
    first += ring.size();
  }
  return chains;
}

/// Everything within `margin_m` of the edges of one kind.
Paths Around(const FlatPolygon& polygon, const std::vector<RegionEdge>& edges, EdgeKind kind,
             double margin_m) {
  ClipperLib::ClipperOffset offset(2.0, kClippersTolerance);
  offset.AddPaths(ChainsOf(polygon, edges, kind), ClipperLib::jtRound, ClipperLib::etOpenRound);
  Paths around;
  offset.Execute(around, (margin_m + 2.0 * kArcTolerance_m) * kUnitsPerMetre);
  return around;
}

Paths Combined(const Paths& polygon, const Paths& other, ClipperLib::ClipType type) {
  ClipperLib::Clipper clipper;
  clipper.AddPaths(polygon, ClipperLib::ptSubject, true);
  clipper.AddPaths(other, ClipperLib::ptClip, true);
  Paths result;
  clipper.Execute(type, result, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
  return result;
}

}  // namespace

FlatPolygon InsetOf(const FlatPolygon& polygon, const std::vector<RegionEdge>& edges,
                    const EdgeMargins& margins) {
  Paths inset = ToUnits(polygon.rings());
  if (margins.all_m > 0.0) {
    ClipperLib::ClipperOffset offset(2.0, kClippersTolerance);
    offset.AddPaths(inset, ClipperLib::jtRound, ClipperLib::etClosedPolygon);
    offset.Execute(inset, -(margins.all_m + kArcTolerance_m) * kUnitsPerMetre);
  }
  Paths strips;
  const auto keep_clear = [&](EdgeKind kind, double margin) {
    if (!(margin > margins.all_m)) return;
    const Paths strip = Around(polygon, edges, kind, margin);
    strips.insert(strips.end(), strip.begin(), strip.end());
  };
  keep_clear(EdgeKind::kDrop, margins.drop_m);
  keep_clear(EdgeKind::kRise, margins.rise_m);
  if (!strips.empty()) inset = Combined(inset, strips, ClipperLib::ctDifference);
  return FromUnits(inset);
}

FlatPolygon Without(const FlatPolygon& polygon, const std::vector<FlatRing>& parts) {
  return FromUnits(Combined(ToUnits(polygon.rings()), ToUnits(parts), ClipperLib::ctDifference));
}

FlatPolygon Within(const FlatPolygon& polygon, const std::vector<FlatRing>& parts) {
  return FromUnits(Combined(ToUnits(polygon.rings()), ToUnits(parts), ClipperLib::ctIntersection));
}

FlatPolygon Within(const FlatPolygon& polygon, const FlatRing& convex) {
  return Within(polygon, std::vector<FlatRing>{convex});
}

}  // namespace terrace
