// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/geometry.h"
#include "datasets/ground_truth.h"

namespace terrace::synthetic {

/// How the brightness of a surface varies; every pattern has detail down to half a millimetre.
enum class Pattern { kPlain, kNoise, kConcrete, kTiles, kWood, kBrick, kChecker, kPosters, kGrating };
inline constexpr int kNumPatterns = 9;
const char* Name(Pattern pattern);  ///< "plain", "noise", ...
std::optional<Pattern> PatternFromName(const std::string& name);

struct Material {
  std::string name;
  Pattern pattern = Pattern::kConcrete;
  double albedo = 0.45;   ///< mean share of the light given back, 0..1
  double contrast = 1.0;  ///< how far the pattern departs from the mean; 0: uniform
  double scale_m = 0.3;   ///< tile, plank, brick height, square, poster spacing or period
  double mirror = 0.0;    ///< share of light reflected as by a mirror, seen straight on
  std::uint32_t seed = 1;
};

/// One true plane: what the truth says of it (outline, holes) and what is drawn of it (convex pieces).
struct Surface {
  std::string name;
  std::string label;  ///< a TerrainLabel by name, or "other"
  Plane plane_world;
  Ring outline_world;             ///< counter-clockwise seen from where the normal points
  std::vector<Ring> holes_world;  ///< the same sense as the outline
  std::vector<Ring> pieces;       ///< convex, the same sense; together they are what light hits
  int material = 0;
  bool detail = false;
  std::optional<int> staircase_id;
  std::optional<int> step_index;
  /// Which moving object this belongs to; none: it stands still and is part of the true map.
  std::optional<int> moving_object;
  /// Value in label images: the polygon's id, or the mesh id of a moving object.
  int image_id = 0;
};

/// A lamp: a rectangle that shines down from the ceiling, or, with `distant`, the sun.
struct Lamp {
  bool distant = false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d(0.6, 0.6);           ///< along x and y
  Eigen::Vector3d direction = Eigen::Vector3d(0.3, 0.2, -1.0);  ///< of the sun's light
  double softness_rad = 0.0;                                    ///< the sun's half width; 0: hard shadows
  double strength = 1.0;  ///< irradiance, over 1, straight below at 1 m, or of the sun on a plane facing it
};

struct Lighting {
  double ambient = 0.4;            ///< irradiance where nothing is in the way
  double occlusion_reach_m = 1.5;  ///< farther surfaces do not darken the ambient light
  double sky = 0.9;                ///< radiance where a ray meets nothing
  double texel_m = 0.04;           ///< spacing of the baked light
  int rays_per_texel = 24;         ///< for each lamp, and for the ambient light
  std::vector<Lamp> lamps;
};

/// What turns light into numbers.
struct Photometry {
  double full_well = 20000.0;  ///< electrons at white
  double read_noise = 10.0;    ///< electrons
  double gain_right = 1.03;    ///< brightness of the right camera over the left
  double exposure_s = 0.004;
  double vignette = 0.3;            ///< loss of light in the image's corner
  double target = 0.17;             ///< mean linear brightness that auto-exposure aims at
  double exposure_speed_hz = 1.25;  ///< share of the (logarithmic) exposure error made good in a second
  double black = 2.0;               ///< grey value of darkness
};

/// A solid that is not part of the map: where it is over time, straight lines between the keys.
struct MovingObject {
  struct Key {
    double t_s;
    Eigen::Vector3d offset;  ///< from where the scene puts it
  };
  std::string name;
  std::vector<Key> keys;
  Eigen::Vector3d base_center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;
  int mesh_id = 0;

  Eigen::Vector3d OffsetAt(double t_s) const;
};

enum class MotionKind { kWalk, kStand, kCreep, kTurnOnSpot };
const char* Name(MotionKind kind);  ///< "walk", "stand", "creep", "turn_on_spot"
std::optional<MotionKind> MotionKindFromName(const std::string& name);

struct MotionPlan {
  MotionKind kind = MotionKind::kWalk;
  std::vector<Eigen::Vector2d> path;  ///< over the ground; the first is the start
  double start_z = 0.0;               ///< height of the ground at the start, to find the right storey
  double heading_rad = 0.0;           ///< of a path with one point
  double speed_mps = 0.45;
  double creep_mps = 0.002;
  double turn_radps = 0.5;
  double hold_start_s = 0.6;
  double hold_end_s = 1.0;
  double gaze_rad = 0.12;   ///< how far the body turns left and right of its way
  double bounce = 1.0;      ///< times the ordinary bounce, roll, pitch and jolts
  double duration_s = 0.0;  ///< 0: until the path is done; stand and creep 60 s, one turn
};

/// A staircase that turns has its truth at the middle of the tread's width, and its direction at its first
/// step.
struct SceneStaircase {
  TrueStaircase truth;
  double turn_per_step_rad = 0.0;
  bool open_risers = false;
};

/// Where the cameras are on the robot.
struct Mounting {
  Eigen::Vector3d left_in_body = Eigen::Vector3d(0.22, 0.06, 0.09);
  double pitch_down_rad = 0.3490658503988659;
  double roll_rad = 0.0;  ///< about the optical axis, clockwise seen from behind; before the pitch
  double body_height_m = 0.36;

  Eigen::Isometry3d T_body_left() const;
};

/// How the right camera stands to the left one, and what of it its calibration does not know.
struct RightCamera {
  bool below = false;         ///< the left one, not beside it
  double roll_rad = 0.0;      ///< its image is turned clockwise
  double row_shift_px = 0.0;  ///< its image is lower, in its middle
  double late_s = 0.0;        ///< its image is taken later than its time stamp says

  /// Of what is built: R_left_right.
  Eigen::Matrix3d Turn(double fy_px) const;
};

/// Everything there is to see, how it is lit, and how the robot moves through it.
struct Scene {
  std::string name;
  std::string description;
  std::vector<Material> materials;
  std::vector<Surface> surfaces;
  std::vector<SceneStaircase> staircases;
  std::vector<MovingObject> moving;
  Lighting lighting;
  Photometry photometry;
  StereoCamera camera{640, 480, 400.0, 400.0, 319.5, 239.5, 0.12};
  Mounting mounting;
  RightCamera right;
  MotionPlan motion;
  double rate_hz = 15.0;
  int max_frames = 0;  ///< 0: as many as the motion lasts
  std::uint32_t seed = 1;
};

}  // namespace terrace::synthetic
