// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>

#include "core/file_bytes.h"
#include "datasets/calibration_file.h"
#include "datasets/image_file.h"
#include "datasets/lcm_event_log.h"
#include "datasets/npz_file.h"
#include "datasets/sequence.h"
#include "results/camera_file.h"
#include "results/explanations_file.h"
#include "results/frames_file.h"
#include "results/map_file.h"
#include "results/stats_file.h"
#include "results/tracks_file.h"
#include "results/trajectory_file.h"
#include "test/fuzz/fuzz_folder.h"
#include "test/fuzz/fuzz_targets.h"

namespace terrace::fuzz {
namespace {

namespace fs = std::filesystem;

/// Runs a reader that may refuse what it reads.
template <typename Read>
void MayRefuse(Read read) {
  try {
    read();
  } catch (const FileError&) {
  } catch (const SequenceError&) {
  }
}

/// Parts that are separated by a zero byte; what is not there is empty.
template <std::size_t count>
std::array<Bytes, count> Parts(Bytes bytes) {
  std::array<Bytes, count> parts;
  for (std::size_t i = 0; i < count; ++i) {
    const auto end = i + 1 < count ? std::find(bytes.begin(), bytes.end(), 0) : bytes.end();
    parts[i] = {bytes.begin(), end};
    bytes = {end == bytes.end() ? end : end + 1, bytes.end()};
  }
  return parts;
}

void ReadImage(Bytes bytes) {
  MayRefuse([&] { DecodeGrayImage(bytes, "image"); });
}
void ReadNpy(Bytes bytes) {
  MayRefuse([&] { ParseNpy({bytes.begin(), bytes.end()}, "array"); });
}
void ReadNpz(Bytes bytes) {
  MayRefuse([&] { ReadNpzFile(Written("arrays.npz", bytes), 1u << 20); });
}

/// By the first byte a name that says what it may be.
void ReadCalibration(Bytes bytes) {
  constexpr std::array<const char*, 5> kNames{"rig.yaml", "rig.json", "rig.txt", "rig.xml", "calib.conf"};
  if (bytes.empty()) return;
  const fs::path path = Written(kNames[bytes[0] % kNames.size()], bytes.subspan(1));
  MayRefuse([&] { ReadCalibrationFiles({path}); });
}

void ReadAll(const fs::path& sequence) {
  MayRefuse([&] {
    constexpr int kMost = 100;  // frames
    const auto opened = OpenSequence(sequence);
    for (int i = 0; i < kMost && opened->Next(); ++i) continue;
  });
}

void ReadLog(Bytes bytes) {
  const fs::path path = Written("log.lcmlog", bytes);
  MayRefuse([&] {
    LcmEventReader reader(path);
    LcmEvent event;
    while (reader.Next(&event)) continue;
  });
  ReadAll(path);
}

void ReadEuroc(Bytes bytes) {
  const auto parts = Parts<6>(bytes);
  Written("euroc/mav0/cam0/sensor.yaml", parts[0]);
  Written("euroc/mav0/cam1/sensor.yaml", parts[1]);
  Written("euroc/mav0/cam0/data.csv", parts[2]);
  Written("euroc/mav0/cam1/data.csv", parts[2]);
  Written("euroc/mav0/imu0/sensor.yaml", parts[3]);
  Written("euroc/mav0/imu0/data.csv", parts[4]);
  Written("euroc/mav0/legs0/data.csv", parts[5]);
  ReadAll(Folder() / "euroc");
}

void ReadKitti(Bytes bytes) {
  const auto parts = Parts<3>(bytes);
  Written("kitti/calib.txt", parts[0]);
  Written("kitti/times.txt", parts[1]);
  Written("kitti/image_0/000000.pgm", parts[2]);
  Written("kitti/image_1/000000.pgm", parts[2]);
  ReadAll(Folder() / "kitti");
}

void ReadResults(Bytes bytes) {
  const fs::path path = Written("result", bytes);
  MayRefuse([&] { ReadCameraFile(path); });
  MayRefuse([&] { ReadExplanationsFile(path); });
  MayRefuse([&] { ReadFramesFile(path); });
  MayRefuse([&] { ReadTerrainMapFile(path); });
  MayRefuse([&] { ReadStaircasesFile(path); });
  MayRefuse([&] { ReadStatsFile(path); });
  MayRefuse([&] { ReadTracksFile(path); });
  MayRefuse([&] { ReadTrajectoryFile(path); });
}

}  // namespace

std::vector<Target> FileTargets() {
  return {{"image", ReadImage}, {"npy", ReadNpy},     {"npz", ReadNpz},     {"calibration", ReadCalibration},
          {"log", ReadLog},     {"euroc", ReadEuroc}, {"kitti", ReadKitti}, {"results", ReadResults}};
}

}  // namespace terrace::fuzz
