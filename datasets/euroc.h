// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "datasets/sequence.h"

namespace terrace {

/// Two images whose time stamps differ by more than this are no pair: a body that turns at 1 rad/s moves its
/// picture by a fifth of a pixel meanwhile.
inline constexpr std::chrono::nanoseconds kMaxPairOffset{500'000};

/// Opens an EuRoC ASL folder: `mav0/cam0` (left), `mav0/cam1` (right), and where present `imu0`,
/// `attitude0` and `legs0`. Body is the frame that the T_BS of the sensors refer to. Images are decoded one
/// pair at a time. Throws SequenceError with every problem.
std::unique_ptr<Sequence> OpenEurocSequence(const std::filesystem::path& path);

/// The calibration alone, of a folder that need not hold images: `mav0/cam0/sensor.yaml`,
/// `mav0/cam1/sensor.yaml` and, where present, `mav0/imu0/sensor.yaml`. Throws SequenceError with every
/// problem.
StereoCalibration ReadEurocCalibration(const std::filesystem::path& path);

}  // namespace terrace
