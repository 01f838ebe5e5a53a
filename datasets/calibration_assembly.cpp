// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_assembly.h"

#include <array>
#include <cmath>
#include <sstream>

#include "core/check.h"
#include "core/lens.h"
#include "core/sensor_frame.h"
#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

std::string ShortNumber(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

std::string SizeWords(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

/// What names of files and folders say about the side.
CameraSide SideOfPath(const fs::path& path) {
  const CameraSide by_file = SideOfName(path.filename().string());
  return by_file != CameraSide::kUnknown ? by_file : SideOfName(path.parent_path().filename().string());
}

/// Fills what `into` leaves open.
void Complete(const CameraPart& from, CameraPart* into) {
  if (into->width == 0) {
    into->width = from.width;
    into->height = from.height;
  }
  if (!into->lens) {
    into->lens = from.lens;
    if (from.lens) into->place = from.place;
  }
  if (!into->T_common_camera) {
    into->T_common_camera = from.T_common_camera;
    into->common = from.common;
  }
}

/// Which camera is left and which is right.
class Sides {
 public:
  Sides(std::vector<CalibrationParts>* files, const std::vector<std::string>& names,
        const RigOptions& options, RigReading* out)
      : out_(out) {
    for (std::size_t i = 0; i < files->size(); ++i) {
      for (CameraPart& part : (*files)[i].cameras) {
        if (part.side == CameraSide::kUnknown && (*files)[i].cameras.size() == 1)
          part.side = SideOfPath(names[i]);
        all_.push_back(&part);
      }
    }
    options.cameras ? Choose(*options.cameras) : Place();
  }

  const CameraPart& left() const { return slots_[0]; }
  const CameraPart& right() const { return slots_[1]; }

 private:
  void Choose(std::pair<int, int> cameras) {
    const int count = static_cast<int>(all_.size());
    for (const auto& [slot, index] : {std::pair{0, cameras.first}, std::pair{1, cameras.second}}) {
      if (index < 0 || index >= count) {
        out_->problems.push_back("there is no camera " + std::to_string(index) + ": the files hold " +
                                 std::to_string(count) + ", counted from 0");
        continue;
      }
      slots_[static_cast<std::size_t>(slot)] = *all_[static_cast<std::size_t>(index)];
    }
  }

  void Place() {
    std::array<const CameraPart*, 2> lens_of{};
    int num_left_out = 0;
    // Those that say their side first.
    for (const bool said : {true, false}) {
      for (const CameraPart* part : all_) {
        if ((part->side != CameraSide::kUnknown) != said) continue;
        std::size_t slot = part->side == CameraSide::kRight ? 1 : 0;
        if (!said && lens_of[0]) slot = 1;
        if (part->lens && lens_of[slot]) {
          if (said) {
            out_->problems.push_back(part->place + " and " + lens_of[slot]->place +
                                     ": both say that they are the " + (slot == 0 ? "left" : "right") +
                                     " camera; --cameras says which is which");
          }
          num_left_out += said ? 0 : 1;
          continue;
        }
        if (part->lens) lens_of[slot] = part;
        Complete(*part, &slots_[slot]);
      }
    }
    if (num_left_out > 0) {
      out_->notes.push_back("the files hold " + std::to_string(all_.size()) +
                            " cameras: the first two are taken; --cameras says otherwise");
    }
  }

  RigReading* out_;
  std::vector<const CameraPart*> all_;
  std::array<CameraPart, 2> slots_;
};

/// The size whose middle is nearest to the principal points, of those that cameras have.
std::pair<int, int> LikelySize(const RawCamera& left, const RawCamera& right) {
  constexpr std::array kSizes = {
      std::pair{320, 240},   std::pair{424, 240},   std::pair{512, 512},   std::pair{640, 360},
      std::pair{640, 400},   std::pair{640, 480},   std::pair{640, 512},   std::pair{672, 376},
      std::pair{752, 480},   std::pair{800, 600},   std::pair{848, 480},   std::pair{1024, 768},
      std::pair{1024, 1024}, std::pair{1241, 376},  std::pair{1242, 375},  std::pair{1280, 720},
      std::pair{1280, 800},  std::pair{1280, 960},  std::pair{1280, 1024}, std::pair{1440, 1080},
      std::pair{1600, 1200}, std::pair{1920, 1080}, std::pair{1920, 1200}, std::pair{2048, 2048},
      std::pair{2208, 1242}, std::pair{480, 640},   std::pair{720, 1280}};
  const Eigen::Vector2d middle(0.5 * (left.cx + right.cx), 0.5 * (left.cy + right.cy));
  std::pair<int, int> best = kSizes.front();
  double best_distance = 1e9;
  for (const auto& size : kSizes) {
    const Eigen::Vector2d centre(0.5 * (size.first - 1), 0.5 * (size.second - 1));
    const double distance = ((middle - centre).array() / centre.array()).matrix().norm();
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = size;
  }
  return best;
}

void SettleSize(const CameraPart& left, const CameraPart& right, const RigOptions& options,
                StereoCalibration* rig, RigReading* out) {
  const CameraPart& sized = left.width > 0 ? left : right;
  if (left.width > 0 && right.width > 0 && (left.width != right.width || left.height != right.height)) {
    out->problems.push_back(right.place + ": images of " + SizeWords(right.width, right.height) +
                            ", the left ones are " + SizeWords(left.width, left.height) +
                            ": must be the same");
  }
  if (options.size) {
    std::tie(rig->width, rig->height) = *options.size;
    if (sized.width > 0 && std::pair(sized.width, sized.height) != *options.size) {
      out->problems.push_back(sized.place + ": is for images of " + SizeWords(sized.width, sized.height) +
                              ", not " + SizeWords(rig->width, rig->height));
    }
  } else if (sized.width > 0) {
    rig->width = sized.width;
    rig->height = sized.height;
  } else {
    std::tie(rig->width, rig->height) = LikelySize(rig->left, rig->right);
    out->notes.push_back("no file says how large the images are: " + SizeWords(rig->width, rig->height) +
                         " is taken, whose middle is nearest to the principal points; --size says otherwise");
  }
}

/// Lengths in metres. A file that does not say its unit has no metres when the cameras would stand further
/// apart than on any robot.
void SettleUnit(const std::optional<double>& unit_m, const RigOptions& options,
                Eigen::Isometry3d* T_right_left, RigReading* out) {
  constexpr double kLongestInMetres = 1.0;
  constexpr double kLongestInCentimetres = 25.0;
  const double length = T_right_left->translation().norm();
  double metres = options.unit_m.value_or(unit_m.value_or(1.0));
  if (!options.unit_m && !unit_m && length > kLongestInMetres) {
    const bool centimetres = length <= kLongestInCentimetres;
    metres = centimetres ? 1e-2 : 1e-3;
    out->notes.push_back("the cameras are " + ShortNumber(length) +
                         " apart, and no file says of what: no metres, taken for " +
                         (centimetres ? "centimetres" : "millimetres") + " (baseline " +
                         ShortNumber(metres * length) + " m); --unit m, cm or mm says otherwise");
  }
  T_right_left->translation() *= metres;
}

std::string CameraOrNothing(const CameraPart& part) { return part.lens ? part.place : "nothing"; }

}  // namespace

RigReading AssembleRig(std::vector<CalibrationParts> files, const std::vector<std::string>& names,
                       const RigOptions& options) {
  RigReading out;
  StereoCalibration rig;
  std::optional<Eigen::Isometry3d> T_right_left, T_common_imu;
  std::optional<double> unit_m = 1.0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const CalibrationParts& file = files[i];
    if (out.format.find(file.format) == std::string::npos) out.format += (i > 0 ? ", " : "") + file.format;
    rig.name += (i > 0 ? " with " : "") + names[i];
    out.notes.insert(out.notes.end(), file.notes.begin(), file.notes.end());
    if (file.T_right_left) T_right_left = file.T_right_left;
    if (!file.unit_m) unit_m.reset();
    if (file.T_common_imu) T_common_imu = file.T_common_imu;
    if (file.imu_minus_camera_s) out.imu_minus_camera_s = file.imu_minus_camera_s;
    if (file.imu_noise.gyro_density > 0.0) rig.imu_noise = file.imu_noise;
  }
  const Sides sides(&files, names, options, &out);
  const CameraPart& left = sides.left();
  const CameraPart& right = sides.right();
  for (const CameraPart* part : {&left, &right}) {
    if (part->lens) out.cameras.push_back({part->place, part->width, part->height, *part->lens});
  }
  const bool related = left.T_common_camera && right.T_common_camera && left.common == right.common;
  if (!T_right_left && options.baseline_m)
    T_right_left = Eigen::Isometry3d(Eigen::Translation3d(-*options.baseline_m, 0, 0));
  if (!T_right_left && related) T_right_left = right.T_common_camera->inverse() * *left.T_common_camera;
  if (out.cameras.empty()) {
    out.missing.push_back("focal lengths and distortion of both cameras");
  } else if (!left.lens || !right.lens) {
    out.missing.push_back("the other camera: left is " + CameraOrNothing(left) + ", right is " +
                          CameraOrNothing(right));
  }
  if (!T_right_left) {
    out.missing.push_back(
        "how the cameras stand to each other: a file with R and T (or both cameras' poses), or "
        "--baseline-m when they are rectified");
  }
  if (!out.missing.empty()) {
    for (const ReadCamera& camera : out.cameras) {
      if (camera.width == 0) continue;
      for (const std::string& problem : LensProblems(camera.lens, camera.width, camera.height))
        out.problems.push_back(camera.place + ": " + problem);
    }
    return out;
  }

  rig.left = *left.lens;
  rig.right = *right.lens;
  SettleSize(left, right, options, &rig, &out);
  SettleUnit(unit_m, options, &*T_right_left, &out);
  rig.T_rawright_rawleft = *T_right_left;
  if (left.T_common_camera && left.common != CommonFrame::kCamera) {
    rig.T_body_rawleft = CanonicalPose(*left.T_common_camera);
    if (left.common == CommonFrame::kImu) T_common_imu = Eigen::Isometry3d::Identity();
    rig.T_body_imu = T_common_imu;
  }
  for (ReadCamera& camera : out.cameras) {
    camera.width = rig.width;
    camera.height = rig.height;
  }
  const std::vector<std::string> senseless = rig.Problems();
  out.problems.insert(out.problems.end(), senseless.begin(), senseless.end());
  out.rig = std::move(rig);
  return out;
}

}  // namespace terrace
