// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <terrace/calibration_v1_t.hpp>
#include <terrace/images_t.hpp>

#include "core/camera.h"
#include "stereo/rectifier.h"
#include "tools/view_record.h"

namespace terrace {

/// Turns stereo pairs into what the page shows: the rectified left image, small enough for a network.
class ViewImages {
 public:
  /// The record of the rectified camera; null when it is the same as before, or none that can be used.
  ViewBytes SetCalibration(const calibration_v1_t& message);

  /// Null without a calibration that fits, or when the pair cannot be read.
  ViewBytes Encode(const images_t& message, Timestamp t_heard) const;

 private:
  std::string content_hash_;
  std::optional<StereoCalibration> calibration_;
  std::optional<Rectifier> rectifier_;
};

/// The rectified camera as the page reads it.
ViewBytes CameraRecord(const StereoCamera& camera);

}  // namespace terrace
