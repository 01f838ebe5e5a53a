// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

using Rows = std::map<std::string, std::vector<double>>;

/// Lines of "NAME: numbers".
Rows RowsOf(const std::string& text) {
  Rows rows;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos) rows[line.substr(0, colon)] = NumbersIn(line.substr(colon + 1));
  }
  return rows;
}

const std::vector<double>& RowOf(const Rows& rows, const std::string& name, std::size_t count,
                                 const std::string& where) {
  const auto found = rows.find(name);
  if (found == rows.end() || found->second.size() != count)
    throw FileError(where + ": line " + name + " must hold " + std::to_string(count) + " numbers");
  return found->second;
}

Eigen::Matrix3d Matrix3Of(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
}

/// A rectified camera: P = K [I | t], p_camera = p_camera0 + t. What P says about y and z is left over from
/// rectifying four cameras together; rows are aligned.
void TakeProjection(const std::vector<double>& P, CameraPart* part) {
  part->lens = RawCamera{P[0], P[5], P[2], P[6], DistortionModel::kRadialTangential, {}};
  part->T_common_camera = Eigen::Isometry3d(Eigen::Translation3d(-P[3] / P[0], 0, 0));
}

}  // namespace

CalibrationParts ReadKittiRaw(const std::string& text, const std::string& where, const ImageSize& size) {
  const Rows rows = RowsOf(text);
  CalibrationParts out;
  out.format = "KITTI raw calib_cam_to_cam.txt";
  bool any_rectified = false;
  for (const char* index : {"00", "01", "02", "03"}) {
    if (!rows.contains(std::string("S_") + index)) continue;
    const auto row = [&](const char* name, std::size_t count) -> const std::vector<double>& {
      return RowOf(rows, std::string(name) + index, count, where);
    };
    CameraPart part;
    part.place = where + ": camera " + index;
    const std::vector<double>& rectified_size = row("S_rect_", 2);
    const bool rectified = size && size->first == static_cast<int>(rectified_size[0]) &&
                           size->second == static_cast<int>(rectified_size[1]);
    const std::vector<double>& image = rectified ? rectified_size : row("S_", 2);
    part.width = static_cast<int>(image[0]);
    part.height = static_cast<int>(image[1]);
    if (rectified) {
      TakeProjection(row("P_rect_", 12), &part);
      any_rectified = true;
    } else {
      part.lens = LensFromMatrix(Matrix3Of(row("K_", 9)), DistortionModel::kRadialTangential, row("D_", 5));
      const std::vector<double>& T = row("T_", 3);
      const auto T_camera_first = PoseFrom(Matrix3Of(row("R_", 9)), {T[0], T[1], T[2]});
      if (!T_camera_first) throw FileError(where + ": line R_" + index + " must be a rotation");
      part.T_common_camera = T_camera_first->inverse();
    }
    out.cameras.push_back(std::move(part));
  }
  if (!any_rectified) {
    out.notes.push_back(
        "read as the calibration of the unrectified images; --size of the rectified ones (as "
        "1242x375) reads that of the synced and rectified recordings");
  }
  return out;
}

CalibrationParts ReadKittiOdometry(const std::string& text, const std::string& where) {
  const Rows rows = RowsOf(text);
  CalibrationParts out;
  out.format = "KITTI odometry calib.txt";
  for (const char* name : {"P0", "P1", "P2", "P3"}) {
    if (!rows.contains(name)) continue;
    CameraPart part;
    part.place = where + ": " + name;
    TakeProjection(RowOf(rows, name, 12, where), &part);
    out.cameras.push_back(std::move(part));
  }
  return out;
}

}  // namespace terrace
