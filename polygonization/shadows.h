// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "polygonization/surface_store.h"

namespace terrace {

/// Matching errors put thin layers in front of and behind a surface. They are many times weaker than the
/// surface, noisy, and lie over it: true for such a layer.
bool IsShadow(SurfaceId id, const SurfaceStore& store);

}  // namespace terrace
