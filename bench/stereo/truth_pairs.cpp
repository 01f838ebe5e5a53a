// SPDX-License-Identifier: BSD-3-Clause
#include "bench/stereo/truth_pairs.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/image_file.h"
#include "datasets/sequence.h"
#include "datasets/synthetic/scene_file.h"
#include "datasets/synthetic/synthesis.h"
#include "evaluation/trajectory_evaluation.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
constexpr int kRenderedRange_px = 128;

cv::Mat1b ReadGray(const fs::path& path) {
  GrayImage image = ReadGrayImage(path);
  return cv::Mat1b(image.height, image.width, image.data.data()).clone();
}

std::vector<fs::path> Folders(const fs::path& parent) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(parent))
    if (entry.is_directory()) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// A folder that goes when it goes out of scope.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = fs::temp_directory_path() / "terrace_stereo_table_XXXXXX";
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder can be made");
    path_ = name;
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

TruthSet ReadMiddleburyV3(const fs::path& data) {
  TruthSet set{"v3", {}, {}, {}};
  for (const fs::path& folder : Folders(data / "middlebury/v3_quarter")) {
    TruthPair pair;
    pair.name = folder.filename();
    pair.frame.left = ReadGray(folder / "im0.png");
    pair.frame.right = ReadGray(folder / "im1.png");
    pair.truth.disparity = LoadPairTruth(folder / "disp0GT.pfm", std::nullopt, std::nullopt);
    std::ifstream calib(folder / "calib.txt");
    for (std::string line; std::getline(calib, line);)
      if (const auto at = line.find("ndisp="); at != std::string::npos)
        pair.max_disparity_px = (std::stoi(line.substr(at + 6)) + 15) / 16 * 16;
    set.pairs.push_back(std::move(pair));
  }
  return set;
}

TruthSet ReadMiddlebury2001To2003(const fs::path& data) {
  const std::map<std::string, double> scales = {{"barn2", 8},    {"bull", 8},  {"cones", 4},    {"poster", 8},
                                                {"sawtooth", 8}, {"teddy", 4}, {"tsukuba", 16}, {"venus", 8}};
  TruthSet set{"2001-2003", {}, {}, {}};
  for (const fs::path& folder : Folders(data / "middlebury/2001_2003")) {
    TruthPair pair;
    pair.name = folder.filename();
    pair.frame.left = ReadGray(folder / "im2.png");
    pair.frame.right = ReadGray(folder / "im6.png");
    pair.truth.disparity = LoadPairTruth(folder / "disp2.png", scales.at(pair.name), std::nullopt);
    set.pairs.push_back(std::move(pair));
  }
  return set;
}

TruthSet WithDamagedRight(TruthSet set) {
  constexpr double kExposure = 0.5, kGain = 1.1, kVignette = 0.8, kBlur_px = 0.8, kRowsOff_px = 0.3,
                   kNoise = 1.0;
  cv::RNG random(1);
  for (TruthPair& pair : set.pairs) {
    cv::Mat1f image, lowered;
    pair.frame.right.convertTo(image, CV_32F);
    cv::GaussianBlur(image, image, {}, kBlur_px);
    const cv::Matx23d down(1, 0, 0, 0, 1, kRowsOff_px);
    cv::warpAffine(image, lowered, down, image.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        const double x = (u - 0.5 * image.cols) / image.cols, y = (v - 0.5 * image.rows) / image.cols;
        const double light = kExposure * kGain * (1.0 - kVignette * (x * x + y * y));
        pair.frame.right(v, u) =
            cv::saturate_cast<std::uint8_t>(light * lowered(v, u) + random.gaussian(kNoise));
      }
  }
  set.name += " damaged";
  return set;
}

Walk ReadWalk(const fs::path& sequence) {
  const std::map<Timestamp, fs::path> depths = TrueDepthImages(sequence), labels = TrueLabelImages(sequence);
  const TrueScene scene = LoadTrueScene(sequence);
  const auto recording = OpenSequence(sequence);
  const Rectifier rectifier(recording->info().calibration);
  ResultCamera camera;
  camera.camera = rectifier.camera();
  const std::vector<TimedPose> poses = TrueLeftPoses(LoadTrueTrajectory(sequence), camera);
  Walk walk{{}, camera.camera};
  while (const std::optional<SensorFrame> sensors = recording->Next()) {
    const Timestamp t = sensors->pair.t_capture;
    Walk::Frame frame;
    frame.frame = rectifier.Rectify(static_cast<FrameId>(walk.frames.size()), sensors->pair);
    frame.T_world_left = MatchPoses({{t, {}}}, poses).at(0).T_true_left;
    if (depths.contains(t)) {
      frame.truth = LoadRenderedTruth(depths.at(t), labels.at(t), scene, camera.camera, frame.T_world_left);
      DisparityTruth& truth = frame.truth->disparity;
      for (std::size_t i = 0; i < truth.pixels.size(); ++i)
        if (truth.disparity_px.data[i] > kRenderedRange_px - 1) truth.pixels[i] = PixelTruth::kNotKnown;
    }
    walk.frames.push_back(std::move(frame));
  }
  return walk;
}

TruthSet ReadRendered(const std::string& name, const fs::path& sequence, int stride) {
  Walk walk = ReadWalk(sequence);
  TruthSet set{name, {}, LoadTrueScene(sequence), walk.camera};
  int num_truths = 0;
  for (Walk::Frame& frame : walk.frames)
    if (frame.truth && num_truths++ % stride == 0)
      set.pairs.push_back({std::to_string(frame.frame.t_capture.ns), frame.frame, kRenderedRange_px,
                           std::move(*frame.truth), frame.T_world_left});
  return set;
}

TruthSet RenderScene(const std::string& scene, double gain, double rate_hz, int max_frames) {
  const TemporaryFolder folder;
  synthetic::SynthesisConfig config;
  config.gain = gain;
  config.rate_hz = rate_hz;
  config.max_frames = max_frames;
  config.truth_every = 1;
  synthetic::Synthesize(synthetic::LoadScene(synthetic::FindScene(scene)), config, folder.path(),
                        [](int, int) {});
  return ReadRendered(scene, folder.path(), 1);
}

}  // namespace terrace
