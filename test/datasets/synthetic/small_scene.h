// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "datasets/synthetic/scene.h"
#include "datasets/synthetic/scene_builder.h"

namespace terrace::synthetic {

/// A textured floor with a box and a flight of three steps, in small images.
inline Scene SmallScene() {
  Scene scene;
  scene.name = "small";
  scene.camera = {160, 120, 100.0, 100.0, 79.5, 59.5, 0.12};
  scene.lighting.texel_m = 0.1;
  scene.lighting.rays_per_texel = 4;
  scene.lighting.lamps.push_back({});
  scene.lighting.lamps.back().center = {1.0, 0.0, 2.5};
  scene.lighting.lamps.back().strength = 3.0;
  scene.materials = {{"noise", Pattern::kNoise, 0.4, 1.0, 0.3, 0.0, 1},
                     {"wood", Pattern::kWood, 0.5, 1.0, 0.1, 0.0, 2}};
  SceneBuilder builder(scene);
  builder.AddFloor({"floor", {-1.0, -2.0}, {5.0, 2.0}, 0.0, "walkway", false}, 0);
  BoxSpec box;
  box.base_center = {1.5, 0.6, 0.0};
  box.yaw_rad = 0.3;
  builder.AddBox(box, 1);
  StaircaseSpec stairs;
  stairs.foot = {2.2, -0.3, 0.0};
  stairs.num_risers = 3;
  stairs.width_m = 1.0;
  stairs.landing_m = 0.8;
  builder.AddStaircase(stairs, 0, 1);
  builder.Finish();
  scene.motion.path = {{0.0, 0.0}, {1.2, 0.0}};
  return scene;
}

}  // namespace terrace::synthetic
