// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_objects.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace terrace::synthetic {
namespace {

/// Labels that truth may carry.
void ReadLabel(Section& section, const std::string& key, std::string* label) {
  static const std::set<std::string> kLabels{"walkway", "ramp",     "stair_tread", "stair_riser",
                                             "wall",    "obstacle", "level",       "other"};
  std::string word = *label;
  section.Word(key, &word);
  if (word != *label && kLabels.count(word) == 0) {
    return section.Say(key, "is '" + word +
                                "', must be walkway, ramp, stair_tread, stair_riser, wall, obstacle, level "
                                "or other");
  }
  *label = word;
}

BoxSpec ReadBox(Section& s) {
  BoxSpec spec;
  s.Word("name", &spec.name);
  s.Vector<3>("base_center_m", &spec.base_center);
  s.Vector<3>("size_m", &spec.size_m, 0.001, kSceneReach_m);
  s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kRadPerDegree);
  s.Number("tilt_deg", &spec.tilt_rad, -90.0, 90.0, kRadPerDegree);
  ReadLabel(s, "top_label", &spec.top_label);
  ReadLabel(s, "side_label", &spec.side_label);
  s.Flag("detail", &spec.detail);
  return spec;
}

}  // namespace

void SceneObjects::Read(Section& s) {
  std::string kind;
  s.Word("kind", &kind);
  const int material = ReadMaterial(s, "material", 0);
  if (kind == "floor" || kind == "ceiling") {
    ReadFloor(s, kind, material);
  } else if (kind == "wall") {
    ReadWall(s, material);
  } else if (kind == "box") {
    builder_.AddBox(ReadBox(s), material);
  } else if (kind == "moving_box") {
    ReadMovingBox(s, material);
  } else if (kind == "quad") {
    ReadQuad(s, material);
  } else if (kind == "staircase") {
    ReadStaircase(s, material);
  } else if (kind == "spiral") {
    ReadSpiral(s, material);
  } else if (kind == "ramp") {
    ReadRamp(s, material);
  } else if (kind == "rubble") {
    ReadRubble(s, material);
  } else {
    s.Say("kind",
          "is '" + kind +
              "', must be floor, ceiling, wall, box, moving_box, quad, staircase, spiral, ramp or rubble");
    return;
  }
  s.RefuseUnknownKeys();
}

int SceneObjects::ReadMaterial(Section& s, const std::string& key, int otherwise) {
  std::string name;
  s.Word(key, &name);
  if (name.empty()) return otherwise;
  const auto found = material_index_.find(name);
  if (found != material_index_.end()) return found->second;
  s.Say(key, "is '" + name + "', must be one of the file's materials");
  return otherwise;
}

void SceneObjects::ReadFloor(Section& s, const std::string& kind, int material) {
  FloorSpec spec;
  spec.name = kind;
  spec.faces_down = kind == "ceiling";
  if (spec.faces_down) spec.label = "other";
  s.Word("name", &spec.name);
  s.Vector<2>("min_m", &spec.min);
  s.Vector<2>("max_m", &spec.max);
  if (!(spec.max.x() > spec.min.x() && spec.max.y() > spec.min.y())) s.Say("max_m", "must lie beyond min_m");
  s.Number("z_m", &spec.z_m, -kSceneReach_m, kSceneReach_m);
  ReadLabel(s, "label", &spec.label);
  builder_.AddFloor(spec, material);
}

void SceneObjects::ReadWall(Section& s, int material) {
  WallSpec spec;
  s.Word("name", &spec.name);
  s.Vector<2>("from_m", &spec.from);
  s.Vector<2>("to_m", &spec.to);
  if ((spec.to - spec.from).norm() < 1e-3) s.Say("to_m", "must differ from from_m");
  s.Number("z_m", &spec.z_m, -kSceneReach_m, kSceneReach_m);
  s.Number("height_m", &spec.height_m, 0.01, 100.0);
  s.Number("thickness_m", &spec.thickness_m, 0.0, 10.0);
  ReadLabel(s, "label", &spec.label);
  const double length = (spec.to - spec.from).norm();
  for (Section& entry : s.Children("openings")) {
    WallSpec::Opening opening{0.0, 1.0, 0.0, 2.0};
    entry.Number("from_m", &opening.from_m, 0.0, length);
    entry.Number("to_m", &opening.to_m, 0.0, length);
    entry.Number("bottom_m", &opening.bottom_m, 0.0, spec.height_m);
    entry.Number("top_m", &opening.top_m, 0.0, spec.height_m);
    if (!(opening.from_m > 0.0 && opening.to_m > opening.from_m && opening.to_m < length)) {
      entry.Say("to_m", "must lie beyond from_m, both inside the wall");
    }
    if (!(opening.top_m > opening.bottom_m && opening.top_m < spec.height_m)) {
      entry.Say("top_m", "must lie between bottom_m and the wall's height");
    }
    entry.RefuseUnknownKeys();
    spec.openings.push_back(opening);
  }
  builder_.AddWall(spec, material);
}

void SceneObjects::ReadMovingBox(Section& s, int material) {
  const BoxSpec spec = ReadBox(s);
  std::vector<MovingObject::Key> keys;
  for (Section& entry : s.Children("keys")) {
    MovingObject::Key key{0.0, Eigen::Vector3d::Zero()};
    entry.Number("t_s", &key.t_s, 0.0, 1e6);
    entry.Vector<3>("offset_m", &key.offset);
    if (!keys.empty() && key.t_s <= keys.back().t_s)
      entry.Say("t_s", "must be later than that of the key before");
    entry.RefuseUnknownKeys();
    keys.push_back(key);
  }
  builder_.AddMovingBox(spec, keys, material);
}

void SceneObjects::ReadQuad(Section& s, int material) {
  QuadSpec spec;
  s.Word("name", &spec.name);
  ReadLabel(s, "label", &spec.label);
  s.Flag("detail", &spec.detail);
  s.Require("corners_m");
  const std::vector<Eigen::Vector3d> corners = s.Vectors<3>("corners_m");
  if (corners.size() != 4) return s.Say("corners_m", "must be four points");
  std::copy(corners.begin(), corners.end(), spec.corners.begin());
  const Eigen::Vector3d normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
  if (normal.norm() < 1e-6 || std::abs(normal.normalized().dot(corners[1] - corners[0])) > 1e-4 ||
      std::abs(normal.normalized().dot(corners[2] - corners[0])) > 1e-4) {
    return s.Say("corners_m", "must lie in one plane within 0.1 mm");
  }
  builder_.AddQuad(spec, material);
}

void SceneObjects::ReadStaircase(Section& s, int material) {
  StaircaseSpec spec;
  s.Word("name", &spec.name);
  s.Vector<3>("foot_m", &spec.foot);
  s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kRadPerDegree);
  s.Count("risers", &spec.num_risers, 2, 100);
  s.Number("riser_m", &spec.riser_m, 0.01, 1.0);
  s.Number("tread_m", &spec.tread_m, 0.05, 5.0);
  s.Number("width_m", &spec.width_m, 0.1, 100.0);
  s.Number("nosing_m", &spec.nosing_m, 0.0, 0.2);
  s.Number("slab_m", &spec.slab_m, 0.005, 0.2);
  s.Flag("open_risers", &spec.open_risers);
  s.Flag("sides", &spec.sides);
  s.Number("landing_m", &spec.landing_m, 0.0, 100.0);
  if (spec.nosing_m >= spec.tread_m) s.Say("nosing_m", "must be smaller than tread_m");
  if (spec.slab_m >= spec.riser_m) s.Say("slab_m", "must be smaller than riser_m");
  builder_.AddStaircase(spec, material, ReadMaterial(s, "riser_material", material));
}

void SceneObjects::ReadSpiral(Section& s, int material) {
  SpiralSpec spec;
  s.Word("name", &spec.name);
  s.Vector<3>("axis_foot_m", &spec.axis_foot);
  s.Number("inner_m", &spec.inner_m, 0.05, 20.0);
  s.Number("outer_m", &spec.outer_m, 0.1, 50.0);
  if (spec.outer_m <= spec.inner_m) s.Say("outer_m", "must be larger than inner_m");
  s.Count("risers", &spec.num_risers, 2, 100);
  s.Number("riser_m", &spec.riser_m, 0.01, 1.0);
  s.Number("start_deg", &spec.start_rad, -360.0, 360.0, kRadPerDegree);
  s.Number("turn_per_step_deg", &spec.turn_per_step_rad, -60.0, 60.0, kRadPerDegree);
  s.Number("landing_deg", &spec.landing_rad, 1.0, 120.0, kRadPerDegree);
  if (std::abs(spec.turn_per_step_rad) < kRadPerDegree)
    s.Say("turn_per_step_deg", "must be at least 1 either way");
  if ((spec.num_risers - 1) * std::abs(spec.turn_per_step_rad) + spec.landing_rad > 350.0 * kRadPerDegree) {
    s.Say("risers", "turn over themselves: steps and landing must stay within 350 degrees");
  }
  builder_.AddSpiral(spec, material, ReadMaterial(s, "riser_material", material));
}

void SceneObjects::ReadRamp(Section& s, int material) {
  RampSpec spec;
  s.Word("name", &spec.name);
  s.Vector<3>("foot_m", &spec.foot);
  s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kRadPerDegree);
  s.Number("length_m", &spec.length_m, 0.05, 100.0);
  s.Number("rise_m", &spec.rise_m, 0.01, 20.0);
  s.Number("width_m", &spec.width_m, 0.05, 100.0);
  s.Number("landing_m", &spec.landing_m, 0.0, 100.0);
  builder_.AddRamp(spec, material);
}

void SceneObjects::ReadRubble(Section& s, int material) {
  RubbleSpec spec;
  s.Word("name", &spec.name);
  s.Vector<2>("min_m", &spec.min);
  s.Vector<2>("max_m", &spec.max);
  s.Number("z_m", &spec.z_m, -kSceneReach_m, kSceneReach_m);
  s.Count("count", &spec.count, 1, 2000);
  s.Number("min_size_m", &spec.min_size_m, 0.01, 5.0);
  s.Number("max_size_m", &spec.max_size_m, 0.01, 5.0);
  s.Number("max_height_m", &spec.max_height_m, 0.005, 5.0);
  s.Number("max_tilt_deg", &spec.max_tilt_rad, 0.0, 60.0, kRadPerDegree);
  s.Number("clear_m", &spec.clear_m, 0.0, 100.0);
  s.Count("seed", &spec.seed, 0, 4294967295.0);
  builder_.AddRubble(spec, material);
}

}  // namespace terrace::synthetic
