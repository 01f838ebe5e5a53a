// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "datasets/synthetic/scene_builder.h"
#include "datasets/synthetic/scene_section.h"

namespace terrace::synthetic {

/// Reads the entries of a scene file's list `objects`, each by its `kind`.
class SceneObjects {
 public:
  /// @param materials  indices of the file's materials by name; must outlive it, as must the builder
  SceneObjects(const std::map<std::string, int>& materials, SceneBuilder* builder)
      : material_index_(materials), builder_(*builder) {}

  void Read(Section& s);

 private:
  int ReadMaterial(Section& s, const std::string& key, int otherwise);
  void ReadFloor(Section& s, const std::string& kind, int material);
  void ReadWall(Section& s, int material);
  void ReadMovingBox(Section& s, int material);
  void ReadQuad(Section& s, int material);
  void ReadStaircase(Section& s, int material);
  void ReadSpiral(Section& s, int material);
  void ReadRamp(Section& s, int material);
  void ReadRubble(Section& s, int material);

  const std::map<std::string, int>& material_index_;
  SceneBuilder& builder_;
};

}  // namespace terrace::synthetic
