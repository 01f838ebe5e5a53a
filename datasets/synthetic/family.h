// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// Kinds of places that are drawn at random, ascending by name (README.md says what each is).
std::vector<std::string> FamilyNames();

/// A place of a family: dimensions, materials, light, things lying about, camera and approach are a pure
/// function of family and seed. Throws SceneError when there is no such family.
Scene DrawPlace(const std::string& family, std::uint32_t seed);

}  // namespace terrace::synthetic
