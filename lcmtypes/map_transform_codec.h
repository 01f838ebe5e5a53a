// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <terrace/map_transform_v1_t.hpp>

#include "core/map_transform.h"

namespace terrace {

map_transform_v1_t ToMessage(const MapTransform& transform);
/// None when a value cannot be meant.
std::optional<MapTransform> FromMessage(const map_transform_v1_t& message);

}  // namespace terrace
