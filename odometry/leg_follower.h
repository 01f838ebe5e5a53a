// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sensor_frame.h"

namespace terrace {

/// How the legs say that the body has moved since the last frame, as long as that can be: relative motion,
/// the pose itself means nothing.
class LegFollower {
 public:
  explicit LegFollower(double max_speed_mps) : max_speed_mps_(max_speed_mps) {}

  /// Takes in what they said since the last frame.
  void Read(const std::vector<BodyPrior>& priors);
  /// Step of the body, with the covariance of the step; none: they have said nothing, something that cannot
  /// be, or are not believed.
  std::optional<BodyPrior> step() const { return refused_ ? std::nullopt : step_; }

  /// They move, and have not agreed with the images for long while moving.
  bool unproven() const;

  /// The images have shown how far the body went meanwhile.
  void Compare(const Eigen::Isometry3d& T_before_body);
  /// From now on they are not believed, until they have agreed with the images for a while.
  void Refuse();
  void Restart();

  /// What the user should be told, once each; none: nothing new.
  std::optional<std::string> TakeWarning();

 private:
  void CompareLengths(double seen_m);
  bool CanBe(const BodyPrior& from, const BodyPrior& to) const;

  double max_speed_mps_;
  std::optional<BodyPrior> newest_;
  std::optional<BodyPrior> step_;
  double said_m_ = 0.0;  ///< length of the step, also when it cannot be

  // While the images showed where the body went.
  double seen_path_m_ = 0.0, said_path_m_ = 0.0;
  bool refused_ = false;
  int num_agreed_ = 0;          ///< frames in a row
  int num_agreed_moving_ = 0;   ///< frames, while something moved
  bool jumped_ = false;         ///< since the last frame
  bool jumped_before_ = false;  ///< likewise in the frame before
  bool jump_told_ = false, length_told_ = false;
  std::optional<std::string> warning_;
};

}  // namespace terrace
