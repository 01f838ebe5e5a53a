// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/mapper_run.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config.h"
#include "test/daemon/tiny_world.h"

namespace terrace {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::string ProblemOf(const PipelineConfig& config) {
  try {
    MapperRun run(config, test::TinyCalibration(), Pace::kEveryFrame, true);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(MapperRunTest, TakesARegionOfInterestWithinTheImageOnly) {
  PipelineConfig config;
  config.stereo.roi_left_px = 80;
  config.stereo.roi_width_px = 80;
  EXPECT_THAT(ProblemOf(config), IsEmpty());
  config.stereo.roi_width_px = 81;
  EXPECT_THAT(ProblemOf(config), HasSubstr("stereo.roi_left_px = 80, stereo.roi_width_px = 81"));
  config.stereo.roi_width_px = 0;
  config.stereo.roi_left_px = 160;
  EXPECT_THAT(ProblemOf(config), HasSubstr("whose width is 160"));
  config.stereo.roi_left_px = 0;
  config.stereo.roi_height_px = 121;
  EXPECT_THAT(ProblemOf(config), HasSubstr("whose height is 120"));
}

TEST(MapperRunTest, ARegionOfInterestLiesInTheHalvedImage) {
  PipelineConfig config;
  config.image_scale.scale = 0.5;
  config.stereo.roi_width_px = 80;
  EXPECT_THAT(ProblemOf(config), IsEmpty());
  config.stereo.roi_width_px = 81;
  EXPECT_THAT(ProblemOf(config), HasSubstr("whose width is 80"));
}

}  // namespace
}  // namespace terrace
