// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "odometry/bridging.h"
#include "odometry/column_monitor.h"
#include "odometry/delay_monitor.h"
#include "odometry/image_pyramid.h"
#include "odometry/imu_check.h"
#include "odometry/imu_watch.h"
#include "odometry/keyframe_archive.h"
#include "odometry/keyframe_maker.h"
#include "odometry/keyframe_policy.h"
#include "odometry/motion_model.h"
#include "odometry/pose_finder.h"
#include "odometry/standing_images.h"
#include "odometry/torn_images.h"
#include "odometry/turn_comparison.h"
#include "odometry/vertical_monitor.h"
#include "odometry/visual_odometry.h"
#include "odometry/window.h"
#include "odometry/window_optimizer.h"
#include "odometry/witness.h"
#include "odometry/world_frame.h"

namespace terrace {

/// One landmark's errors in neighbouring frames resemble each other (texture, interpolation, slant), so that
/// many observations know less than their number says. Measured on rendered walks, in variance.
constexpr double kCorrelation = 4.5;

/// What the odometry knows from frame to frame, and its steps, by what they are about in a file each.
class VisualOdometry::Impl {
 public:
  Impl(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting);

  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples);
  PoseEstimate Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                      const std::string& reason);
  /// What is given out: with the epoch, what is not yet known of the pair, and whether it may be mapped.
  PoseEstimate Published(PoseEstimate pose) const;
  bool pair_was_never_right() const { return columns_.is_off() || (delay_.is_off() && !delay_.was_right()); }
  /// Samples that can have been measured; tells the user once when some cannot.
  SensorSamples Believable(const SensorSamples& samples);

  const Gravity& gravity() const { return gravity_.gravity(); }
  const FrameSightings& sightings() const { return sightings_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  void Apply(const GravityHint& hint) { gravity_.Take(hint); }
  void HearOfPair(const PairTrouble& trouble) { pair_trouble_ = trouble; }

 private:
  // Frames that show where the camera is: visual_odometry.cpp.
  PoseEstimate Tracked(const StereoFrame& frame, const PoseFinder::Found& found);
  void Remember(const PoseEstimate& pose);

  // Whether the two cameras see what a pair sees: visual_odometry_pair.cpp.
  /// What the landmarks' places in both images say of it.
  void WatchPair(const PoseFinder::Found& found, const PoseEstimate& pose, double dt_s);
  /// The right image is the one of the frame before, as it may be now and then where images get lost. A
  /// camera that stays frozen is the dense comparison's matter: keyframes must go on.
  bool OneImageIsOld() const {
    constexpr int kLasts = 3;  // frames
    return standing_.num_right_alone() > 0 && standing_.num_right_alone() <= kLasts;
  }
  /// Then distances are wrong, and the pose is off by a share of the way.
  bool PairInDoubt() const {
    return delay_.is_off() || torn_.torn() || columns_.is_off() || OneImageIsOld() ||
           !pair_trouble_.reason.empty();
  }
  /// Why; and what kind of reason that is.
  std::pair<std::string, ReasonCode> PairsTrouble() const;
  /// As long as motion has not shown it: what the pose may be off by because a camera is late, or columns
  /// are off.
  Matrix6d NotYetKnown(const PoseEstimate& pose) const;

  // How a world begins: visual_odometry_start.cpp.
  /// @param biases  of the IMU, as far as they are known
  PoseEstimate Start(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                     const SensorSamples& samples, const KeyframeState& biases);
  /// With the first keyframe in it. The floor that this shows may confirm a body that was taken for the axes
  /// of a sensor, where the robot itself says nothing.
  WorldFrame LayWorld(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                      const SensorSamples& samples);
  Eigen::Vector3d DownIfLevel(const Eigen::Isometry3d& T_world_left) const;
  /// Where the camera has come to cannot be known any more: another world begins at this frame.
  PoseEstimate BeginAnew(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                         const SensorSamples& samples);
  /// For too long the images and a sensor have excluded each other.
  PoseEstimate BeginWithout(const Motion& predicted, const StereoFrame& frame, const ImagePyramid& left,
                            const ImagePyramid& right, const SensorSamples& samples);

  // What IMU, legs and attitude say, and whether the images agree: visual_odometry_sensors.cpp.
  void Read(const SensorSamples& samples, Timestamp t_capture);
  void ReadImu(const std::vector<ImuSample>& samples, Timestamp t_capture);
  /// Why these images cannot be what the cameras see now; empty: they can. Both standing still is no fault of
  /// a robot that stands, or of a recording of one pair.
  std::string Frozen(const Motion& predicted);
  /// What the camera has moved since cannot be seen in an image that was seen before.
  static void AddUnseen(const Motion& predicted, PoseEstimate* pose);
  void RefuseImu(const std::string& why);
  /// What the sensor that has measured the motion says to what the images show. Who has contradicted until
  /// all was lost does so still.
  Witness::Verdict Hear(const Expectation& expected, const Motion& predicted,
                        const Eigen::Isometry3d& T_world_found);
  /// Why the IMU cannot be believed, by what the images show.
  std::optional<std::string> ImuProblem(const Expectation& expected, const Motion& predicted,
                                        const Eigen::Isometry3d& T_world_found);
  /// What passes by hardly seems to turn the camera: then it is the IMU that is wrong. Legs slip a little
  /// all the time, and as long as they have not walked in agreement they may be wrong altogether.
  bool WitnessIsWrong(Witness::Verdict verdict, const Motion& predicted);
  /// The images and the sensor exclude each other, and a thing that fills the view is likelier than a sensor
  /// that fails just now: goes on by the sensor, uncertain by how far the two are apart.
  PoseEstimate Contradicted(const StereoFrame& frame, const Motion& predicted,
                            const Eigen::Isometry3d& T_world_found);
  void Doubt(const Motion& predicted, PoseEstimate* pose);
  static std::string Apart(const Motion& predicted);

  // Where the camera can be, and what becomes of frames that do not show it: visual_odometry_unfound.cpp.
  /// What cannot be is not predicted: then the camera is taken to stay where it is.
  Motion Predict(Timestamp t_capture) const;
  /// False for what is farther than the robot can go in this time.
  bool CanMove(const Eigen::Isometry3d& T_last_left, double dt_s) const;
  bool CanHaveMovedTo(const Eigen::Isometry3d& T_world_left, double dt_s) const;
  /// The clock was set back: nobody knows how much time has passed.
  void LoseTime(Timestamp t_capture);
  bool Lost() const { return bridging_.bridged_s() > config_.max_bridging_s; }
  /// How well the IMU's state is known after bridging by it.
  ImuSigmas BridgedImu() const;
  Expectation Expected(const StereoFrame& frame, const Motion& predicted) const;
  PoseEstimate Bridged(FrameId frame_id, Timestamp t_capture, const Motion& predicted,
                       const std::string& reason);
  /// Nothing of the window was found: bridge, and look whether the place is known from before. When images
  /// stay good but strange, a new window starts from the bridged pose; where nobody knows any more where that
  /// is, another world begins.
  PoseEstimate Unfound(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                       const SensorSamples& samples, const Motion& predicted);
  /// What has been strange for some frames is a place known well, and far from where it can be.
  /// @param near  what was recognised nearby
  bool HasJumped(const std::optional<KeyframeArchive::Recognition>& near, const ImagePyramid& left,
                 const std::vector<Landmark>& landmarks, const PoseEstimate& pose) const;
  /// The camera was carried there, or the player of a recording was started again: what the IMU, the legs and
  /// the motion so far say about where it is now is nothing.
  PoseEstimate Jumped(PoseEstimate pose);

  // Keyframes and the window of them: visual_odometry_keyframes.cpp.
  void AddKeyframe(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                   const Eigen::Isometry3d& T_world_left, const PoseFinder::Found& found);
  /// A fresh prior, on the oldest keyframe of the window.
  /// @param imu  none: nothing is known of it but what it should be
  void StartWindow(const Matrix6d& pose_covariance, const std::optional<ImuSigmas>& imu = std::nullopt);
  /// After a keyframe: all poses of the window together, then the oldest leaves.
  void RefineWindow(PoseEstimate* pose);

  OdometryConfig config_;
  StereoCamera camera_;
  Mounting mounting_;
  FeatureGrid grid_;
  MotionModel motion_;
  PoseFinder pose_finder_;
  KeyframePolicy keyframe_policy_;
  KeyframeMaker keyframe_maker_;
  WindowOptimizer optimizer_;
  KeyframeArchive archive_;
  GravityKeeper gravity_;
  VerticalMonitor vertical_;
  ColumnMonitor columns_;
  DelayMonitor delay_;
  TornImages torn_;
  PairTrouble pair_trouble_;
  ImuCheck imu_check_;
  ImuWatch imu_watch_;
  TurnComparison turns_;
  StandingImages standing_;
  Bridging bridging_;
  Witness witness_;

  Window window_;
  Matrix6d keyframe_covariance_ = Matrix6d::Zero();  ///< of the newest keyframe against the first pose
  std::optional<PoseEstimate> last_;
  /// By how much images and a sensor have excluded each other since the last tracked frame.
  Matrix6d contested_ = Matrix6d::Zero();
  Matrix6d own_covariance_ = Matrix6d::Zero();  ///< of the last tracked frame against its keyframe
  Matrix6d squared_speed_ = Matrix6d::Zero();   ///< of the last tracked frames; left frame, per second
  Eigen::Vector3d start_world_ = Eigen::Vector3d::Zero();  ///< where this world began
  double typical_disparity_px_ = 1.0;                      ///< of the last tracked frame
  bool imu_contested_ = false;  ///< it and the images had excluded each other when this world began
  bool frozen_ = false;         ///< both cameras, since their images stand
  int epoch_ = 0;
  int num_incredible_ = 0;      ///< readings that no sensor can have made
  int num_strange_frames_ = 0;  ///< in a row, with features enough but none of the window's
  FrameSightings sightings_;    ///< of the last frame
  std::vector<std::string> warnings_;
};

}  // namespace terrace
