// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/time.h"
#include "polygonization/outline_tracer.h"
#include "polygonization/polygon.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// The first revision of a polygon: one piece of a surface as the surface's plane lies now.
Polygon MakePolygon(PolygonId id, const Surface& surface, const TracedPiece& piece, Timestamp t_capture);

/// Whether a polygon moved, grew or shrank by more than `min_change_m` anywhere along its outline, on average
/// where it is an edge in the plane.
bool HasChanged(const Polygon& before, const Polygon& now, double min_change_m);

}  // namespace terrace
