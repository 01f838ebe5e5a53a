// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/camera.h"

namespace terrace {

inline const StereoCamera kVgaCamera{640, 480, 400.0, 400.0, 319.5, 239.5, 0.12};
inline const StereoCamera kHalfVgaCamera{320, 240, 200.0, 200.0, 159.5, 119.5, 0.12};

}  // namespace terrace
