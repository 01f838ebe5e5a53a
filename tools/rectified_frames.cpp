// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectified_frames.h"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "datasets/calibration_file.h"
#include "datasets/sequence.h"
#include "stereo/image_scale.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

/// Rectifies as the replay did.
struct ReplayedRectifier {
  ImageScaleConfig scale;
  Rectifier rectifier;
};

ReplayedRectifier RectifierOf(const StereoCalibration& calibration, const StereoCamera& camera) {
  for (const double scale : {1.0, 0.5, 0.25}) {
    const Rectifier by_default(Scaled(calibration, {scale}));
    const StereoCamera& view = by_default.camera();
    if (view.width == camera.width && view.height == camera.height && std::abs(view.fx - camera.fx) < 1e-6)
      return {{scale}, by_default};
  }
  return {{},
          Rectifier(calibration,
                    {camera.fx, std::to_string(camera.width) + "x" + std::to_string(camera.height)})};
}

}  // namespace

void ForRectifiedFrames(const std::filesystem::path& path, const ChannelConfig& channels,
                        const std::vector<std::filesystem::path>& files, const StereoCamera& camera,
                        const std::function<bool(const SensorFrame&)>& wanted,
                        const std::function<bool(const StereoFrame&)>& use) {
  const auto sequence = OpenSequence(path, channels);
  StereoCalibration calibration = sequence->info().calibration;
  if (!files.empty()) {
    RigOptions rig_options;
    rig_options.size = {calibration.width, calibration.height};
    std::vector<std::string> notes;
    calibration = ReadRig(files, &notes, rig_options);
  }
  const ReplayedRectifier replayed = RectifierOf(calibration, camera);
  while (const std::optional<SensorFrame> frame = sequence->Next()) {
    if (!wanted(*frame)) continue;
    if (!frame->pair.problem.empty()) throw std::runtime_error(frame->pair.problem);
    if (!use(replayed.rectifier.Rectify(frame->frame_id, Scaled(frame->pair, replayed.scale)))) return;
  }
}

}  // namespace terrace
