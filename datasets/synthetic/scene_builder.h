// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// A level rectangle.
struct FloorSpec {
  std::string name = "floor";
  Eigen::Vector2d min{0, 0};
  Eigen::Vector2d max{1, 1};
  double z_m = 0.0;
  std::string label = "walkway";
  bool faces_down = false;  ///< a ceiling
};

/// An upright rectangle seen from the left of the way from `from` to `to`; with a thickness also from behind.
struct WallSpec {
  struct Opening {
    double from_m, to_m;     ///< along the wall
    double bottom_m, top_m;  ///< above its foot
  };
  std::string name = "wall";
  Eigen::Vector2d from{0, 0};
  Eigen::Vector2d to{1, 0};
  double z_m = 0.0;
  double height_m = 2.5;
  double thickness_m = 0.0;
  std::string label = "wall";
  std::vector<Opening> openings;
};

/// A block that stands on its base.
struct BoxSpec {
  std::string name = "box";
  Eigen::Vector3d base_center{0, 0, 0};
  Eigen::Vector3d size_m{0.4, 0.4, 0.4};
  double yaw_rad = 0.0;
  double tilt_rad = 0.0;  ///< about its own y axis, after which it is sunk by half its height
  std::string top_label = "obstacle";
  std::string side_label;  ///< empty: wall when 1 m or higher, else obstacle
  bool detail = false;
};

/// Four corners, counter-clockwise from where they are seen, in one plane.
struct QuadSpec {
  std::string name = "quad";
  std::array<Eigen::Vector3d, 4> corners;
  std::string label = "other";
  bool detail = false;
};

/// A straight flight. Riser 1 stands on the foot edge.
struct StaircaseSpec {
  std::string name = "stairs";
  Eigen::Vector3d foot{0, 0, 0};  ///< middle of the foot edge
  double yaw_rad = 0.0;           ///< up the stairs
  int num_risers = 6;
  double riser_m = 0.17;
  double tread_m = 0.28;
  double width_m = 1.2;
  double nosing_m = 0.0;  ///< treads reach over their riser by this
  double slab_m = 0.04;   ///< thickness of treads with a nosing or with open risers
  bool open_risers = false;
  bool sides = true;       ///< faces left and right; not needed between walls
  double landing_m = 0.0;  ///< length of a solid platform at the top; 0: what follows is a floor of its own
};

/// Steps about an upright axis, solid down to the ground.
struct SpiralSpec {
  std::string name = "spiral";
  Eigen::Vector3d axis_foot{0, 0, 0};
  double inner_m = 0.25;
  double outer_m = 1.4;
  int num_risers = 10;
  double riser_m = 0.17;
  double start_rad = 0.0;               ///< direction from the axis to the first riser
  double turn_per_step_rad = 0.392699;  ///< positive: turns left going up
  double landing_rad = 0.8;             ///< of the platform behind the last riser
};

/// An inclined plane, solid, with its sides.
struct RampSpec {
  std::string name = "ramp";
  Eigen::Vector3d foot{0, 0, 0};
  double yaw_rad = 0.0;
  double length_m = 2.0;  ///< over the ground
  double rise_m = 0.35;
  double width_m = 1.2;
  double landing_m = 0.0;
};

/// Blocks thrown about.
struct RubbleSpec {
  std::string name = "rubble";
  Eigen::Vector2d min{0, 0};
  Eigen::Vector2d max{1, 1};
  double z_m = 0.0;
  int count = 30;
  double min_size_m = 0.08;
  double max_size_m = 0.35;
  double max_height_m = 0.15;
  double max_tilt_rad = 0.25;
  double clear_m = 0.0;  ///< no block's middle nearer than this to the line y = middle of the area
  std::uint32_t seed = 1;
};

/// Makes the planes of solids, each with its label, so that truth and picture agree.
class SceneBuilder {
 public:
  explicit SceneBuilder(Scene& scene) : scene_(scene) {}

  void AddFloor(const FloorSpec& spec, int material);
  void AddWall(const WallSpec& spec, int material);
  void AddBox(const BoxSpec& spec, int material);
  void AddMovingBox(const BoxSpec& spec, const std::vector<MovingObject::Key>& keys, int material);
  void AddQuad(const QuadSpec& spec, int material);
  void AddStaircase(const StaircaseSpec& spec, int material, int riser_material);
  void AddSpiral(const SpiralSpec& spec, int material, int riser_material);
  void AddRamp(const RampSpec& spec, int material);
  void AddRubble(const RubbleSpec& spec, int material);

  /// One plane of a solid. The reference holds until the next one is added.
  Surface& AddFace(const std::string& name, const std::string& label, const Ring& outline, int material);
  /// Where a solid stands on the ground: level, counter-clockwise from above.
  void AddFootprint(Ring outline) { footprints_.push_back(std::move(outline)); }

  /// Numbers the polygons and cuts what stands on a floor out of it. Call once, last.
  void Finish();

 private:
  Scene& scene_;
  std::vector<Ring> footprints_;
};

}  // namespace terrace::synthetic
