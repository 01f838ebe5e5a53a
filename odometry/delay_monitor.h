// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/time.h"
#include "odometry/landmark_tracker.h"
#include "odometry/window.h"

namespace terrace {

/// Follows by how much the right camera is late, or, negative, the left one. In an image of another moment
/// everything has moved on: the rows of its landmarks are off by how fast these move up or down, times the
/// delay, beside what a wrong calibration adds, which stays. Columns cannot tell, as they hold the disparity.
class DelayMonitor {
 public:
  explicit DelayMonitor(const StereoCamera& camera);

  /// Takes in where a tracked frame found the window's landmarks. How fast they move in a frame is known with
  /// the frame after it.
  /// @return what the user should be told, when that changes
  std::optional<std::string> Update(const Window& window, const std::vector<Match>& matches,
                                    Timestamp t_capture);

  double delay_s() const { return delay_s_; }
  double sigma_s() const { return sigma_s_; }
  /// The two images are not of one moment.
  bool is_off() const { return is_off_; }
  /// Motion has shown once that the two are of one moment.
  bool was_right() const { return was_right_; }
  std::string Reason() const;

 private:
  /// Shift, roll, stretch and turn of the right image, a baseline that leans up or forward, in which rows of
  /// what is near are off as they are while the camera drives ahead, and last the delay.
  static constexpr int kNumUnknowns = 7;
  using Unknowns = Eigen::Matrix<double, kNumUnknowns, 1>;
  using Information = Eigen::Matrix<double, kNumUnknowns, kNumUnknowns>;

  struct Place {
    Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();
    bool in_right = false;
    double lower_px = 0.0;  ///< v in the right image less v in the left one
  };
  struct Sighting {
    Timestamp t_capture;
    std::vector<std::pair<std::int64_t, Place>> places;  // by landmark, ascending
  };
  /// What one landmark's rows are off by, for each unknown, and what they are off by.
  struct Row {
    Unknowns influence;
    double lower_px = 0.0;
  };

  /// Of the frame before, whose landmarks are seen before and after it.
  std::vector<Row> RowsBetween(const Sighting& after) const;
  void Learn(const std::vector<Row>& rows);

  StereoCamera camera_;
  std::optional<Sighting> before_, middle_;
  Information prior_ = Information::Zero();
  Information information_ = Information::Zero();  ///< of rows that are wrong by kNominal_px; forgets
  Unknowns weighted_ = Unknowns::Zero();           ///< likewise, the right-hand side
  double scatter_px_;                              ///< of rows about what was found, running mean
  double delay_s_ = 0.0, sigma_s_;
  bool is_off_ = false, was_right_ = false;
};

}  // namespace terrace
