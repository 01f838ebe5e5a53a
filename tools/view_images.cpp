// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_images.h"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"

namespace terrace {
namespace {

constexpr int kJpegQuality = 70;

}  // namespace

ViewBytes CameraRecord(const StereoCamera& camera) {
  const nlohmann::json json = {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
                               {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
  return MakeViewRecord(ViewRecordKind::kCamera, {}, json.dump());
}

ViewBytes ViewImages::SetCalibration(const calibration_v1_t& message) {
  if (rectifier_ && message.content_hash == content_hash_) return nullptr;
  content_hash_ = message.content_hash;
  rectifier_.reset();
  calibration_ = FromMessage(message);
  if (!calibration_ || !calibration_->Problems().empty()) return nullptr;
  rectifier_.emplace(*calibration_);
  return CameraRecord(rectifier_->camera());
}

ViewBytes ViewImages::Encode(const images_t& message, Timestamp t_heard) const {
  if (!rectifier_) return nullptr;
  const StereoPair pair = FromMessage(message);
  const bool fits = pair.problem.empty() && pair.left.width == calibration_->width &&
                    pair.left.height == calibration_->height && pair.right.width == pair.left.width &&
                    pair.right.height == pair.left.height;
  if (!fits) return nullptr;
  const StereoFrame frame = rectifier_->Rectify(0, pair);
  std::vector<std::uint8_t> jpeg;
  if (!cv::imencode(".jpg", frame.left, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) return nullptr;
  return MakeViewRecord(ViewRecordKind::kImage, pair.t_capture, t_heard, jpeg.data(), jpeg.size());
}

}  // namespace terrace
