// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "stereo/rectifier.h"

namespace terrace {
namespace {

/// A 752x480 pair with the lenses of an EuRoC rig.
StereoCalibration EurocLikeRig() {
  StereoCalibration c;
  c.name = "rig";
  c.width = 752;
  c.height = 480;
  c.left = {458.654,
            457.296,
            367.215,
            248.375,
            DistortionModel::kRadialTangential,
            {-0.2834, 0.0740, 1.9e-4, 1.8e-5}};
  c.right = {457.587,
             456.134,
             379.999,
             255.238,
             DistortionModel::kRadialTangential,
             {-0.2837, 0.0745, -1e-4, -3.6e-5}};
  c.T_rawright_rawleft.linear() =
      Eigen::AngleAxisd(0.014, Eigen::Vector3d(0.97, 0.16, 0.16).normalized()).matrix();
  c.T_rawright_rawleft.translation() = Eigen::Vector3d(-0.110, 0.0004, -0.0009);
  return c;
}

void BM_RectifyPair(benchmark::State& state) {
  const Rectifier rectifier(EurocLikeRig());
  StereoPair pair;
  pair.left = pair.right = {752, 480, std::vector<std::uint8_t>(752 * 480)};
  for (std::size_t i = 0; i < pair.left.data.size(); ++i)
    pair.left.data[i] = static_cast<std::uint8_t>(i * 31);
  for (auto _ : state) benchmark::DoNotOptimize(rectifier.Rectify(0, pair));
}
BENCHMARK(BM_RectifyPair)->Unit(benchmark::kMillisecond);

void BM_BuildTables(benchmark::State& state) {
  const StereoCalibration calibration = EurocLikeRig();
  for (auto _ : state) benchmark::DoNotOptimize(Rectifier(calibration));
}
BENCHMARK(BM_BuildTables)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrace
