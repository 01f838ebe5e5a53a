// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry.h"

namespace terrace {

/// Compares, frame by frame, the motion that the images show with the one that a sensor has measured. What
/// fills the view and moves cannot be told from a motion of the camera by the images alone. A sensor that has
/// not yet agreed for a while says nothing: it may be wired or mounted wrongly.
class Witness {
 public:
  enum class Verdict {
    kAgrees,
    kDriftsApart,  ///< each frame for itself is possible, but they lead apart: the pose is in doubt
    kContradicts,  ///< one of the two is wrong in this frame
    kAgreesAgain,  ///< for so short a time that it may be by chance
  };

  /// @param error  step from where the sensor expects the camera to where the images show it
  /// @param covariance  of the expectation, at the worst
  Verdict Hear(const Vector6d& error, const Matrix6d& covariance, double dt_s);
  /// Nothing that was heard counts any more: it has to prove itself anew.
  void Reset() { *this = {}; }

  /// It has agreed for long enough that what it says counts.
  bool proven() const;
  /// For how long it has contradicted or drifted apart without agreeing in between.
  double disagreed_s() const { return disagreed_s_; }
  bool contradicts() const { return contradicts_; }
  /// It contradicts in the rotation. Things that pass by seem to move the camera, but hardly to turn it.
  bool turns_otherwise() const { return turns_otherwise_; }
  /// By how much the two have come apart over the last second; while it contradicts, in this frame.
  const Vector6d& apart() const { return contradicts_ ? error_ : apart_; }

 private:
  Vector6d error_ = Vector6d::Zero();
  Vector6d apart_ = Vector6d::Zero();
  Matrix6d apart_covariance_ = Matrix6d::Zero();
  double disagreed_s_ = 0.0;
  bool contradicts_ = false;
  bool turns_otherwise_ = false;
  int num_agreed_ = 0;
  int num_agreed_again_ = 0;  ///< in a row, since it contradicted
};

}  // namespace terrace
