// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "polygonization/plane_bitmap.h"
#include "polygonization/ring_simplifier.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// Cuts a surface where other surfaces that were seen meet it, and fills it up to there: floors end at walls,
/// treads at risers, ramps at the floor before them. Returns the stretches of the lines of intersection along
/// which it was cut, in the coordinates of the surface.
std::vector<EdgeLine> CutAtJoints(SurfaceId id, const Neighbours& neighbours, const SurfaceStore& store,
                                  PlaneBitmap* bitmap);

}  // namespace terrace
