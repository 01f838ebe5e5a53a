// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/family.h"

#include <functional>
#include <map>

#include "datasets/synthetic/place.h"
#include "datasets/synthetic/scene_file.h"

namespace terrace::synthetic {
namespace {

using DrawFamily = std::function<void(Place&)>;

const std::map<std::string, DrawFamily>& Families() {
  static const std::map<std::string, DrawFamily> families{
      {"up", DrawStairsUp},
      {"up_free", DrawStairsUpFree},
      {"down", DrawStairsDown},
      {"open", DrawStairsOpen},
      {"spiral_left", [](Place& place) { DrawSpiral(place, 1.0); }},
      {"spiral_right", [](Place& place) { DrawSpiral(place, -1.0); }},
      {"dogleg", DrawDogleg},
      {"drop", DrawDrop},
      {"ramp", DrawRamp},
      {"kerb", DrawKerb},
      {"clutter", DrawClutter},
  };
  return families;
}

}  // namespace

std::vector<std::string> FamilyNames() {
  std::vector<std::string> names;
  for (const auto& [name, draw] : Families()) names.push_back(name);
  return names;
}

Scene DrawPlace(const std::string& family, std::uint32_t seed) {
  const auto found = Families().find(family);
  if (found == Families().end()) {
    std::string known;
    for (const std::string& name : FamilyNames()) known += (known.empty() ? "" : ", ") + name;
    throw SceneError("'" + family + "' is not a family of places: " + known);
  }
  Place place(family, seed);
  found->second(place);
  return place.Finish();
}

}  // namespace terrace::synthetic
