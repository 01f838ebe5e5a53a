// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/calibration_parts.h"
#include "datasets/yaml_value.h"

namespace terrace {

/// What a reader may know beside the file: the size of the images, where a file holds several.
using ImageSize = std::optional<std::pair<int, int>>;

// One function a format; each throws FileError with the place and the rule. The trees are whole files.

CalibrationParts ReadKalibr(const YamlValue& root);     ///< camchain, camchain-imucam, OpenVINS
CalibrationParts ReadCamodocal(const YamlValue& root);  ///< camodocal, VINS: one camera
CalibrationParts ReadVinsConfig(const YamlValue& root, const std::filesystem::path& folder);
CalibrationParts ReadBasalt(const YamlValue& root);
CalibrationParts ReadOpenCv(const YamlValue& root);         ///< FileStorage, intrinsics or extrinsics or both
CalibrationParts ReadRosCameraInfo(const YamlValue& root);  ///< file of camera_calibration, or the message
CalibrationParts ReadEurocSensor(const YamlValue& root);
CalibrationParts ReadEcon(const YamlValue& root);
CalibrationParts ReadOak(const YamlValue& root);        ///< depthai's eepromToJson
CalibrationParts ReadRealSense(const YamlValue& root);  ///< intrinsics and extrinsics of its SDK as JSON
CalibrationParts ReadRigFile(const YamlValue& root);    ///< our own

CalibrationParts ReadRosOst(const std::string& text, const std::string& where);
CalibrationParts ReadKittiRaw(const std::string& text, const std::string& where, const ImageSize& size);
CalibrationParts ReadKittiOdometry(const std::string& text, const std::string& where);
CalibrationParts ReadZedConf(const std::string& text, const std::string& where, const ImageSize& size);
CalibrationParts ReadZedText(const std::string& text, const std::string& where);
/// What `rs-enumerate-devices -c` prints.
CalibrationParts ReadRealSenseText(const std::string& text, const std::string& where, const ImageSize& size);

// What several of them share.

/// The lens model of a name that any of the formats uses; none: not known.
std::optional<DistortionModel> ModelOfAnyName(std::string name);
/// fx, 0, cx, 0, fy, cy, 0, 0, 1.
RawCamera LensFromMatrix(const Eigen::Matrix3d& K, DistortionModel model, std::vector<double> distortion);
/// "left", "cam1", "RIGHT_CAM": a side; anything else: unknown.
CameraSide SideOfName(std::string name);
/// Every number in a text, whatever stands between them.
std::vector<double> NumbersIn(const std::string& text);

}  // namespace terrace
