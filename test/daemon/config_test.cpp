// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::HasSubstr;

namespace fs = std::filesystem;

class ConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::path(testing::TempDir()) /
           ("terrace_config_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  fs::path File(const std::string& text) const {
    const fs::path path = dir_ / "robot.yaml";
    std::ofstream(path) << text;
    return path;
  }

  static std::string ErrorOf(const std::optional<fs::path>& file, const std::vector<std::string>& settings) {
    try {
      LoadConfig(file, settings);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }

  fs::path dir_;
};

TEST_F(ConfigTest, TakesAWordWhereAWholeNumberMayBeChosen) {
  EXPECT_EQ(LoadConfig({}, {"stereo.max_disparity_px=auto"}).pipeline.stereo.max_disparity_px, std::nullopt);
}

TEST_F(ConfigTest, NeedsNoFile) { EXPECT_EQ(LoadConfig({}, {}).pipeline.stereo.max_disparity_px, 128); }

TEST_F(ConfigTest, SpeaksWhereLcmsOwnProgramsDoUnlessItIsToldWhere) {
  const std::string usual = LoadConfig({}, {}).live.url;
  ASSERT_EQ(setenv("LCM_DEFAULT_URL", "udpm://239.255.76.99:7699?ttl=0", 1), 0);
  EXPECT_EQ(LoadConfig({}, {}).live.url, "udpm://239.255.76.99:7699?ttl=0");
  EXPECT_EQ(LoadConfig({}, {"lcm.url=memq://"}).live.url, "memq://");
  EXPECT_EQ(LoadConfig(File("lcm:\n  url: memq://\n"), {}).live.url, "memq://");
  ASSERT_EQ(setenv("LCM_DEFAULT_URL", "", 1), 0);
  EXPECT_EQ(LoadConfig({}, {}).live.url, usual) << "empty is as if it were not set";
  ASSERT_EQ(unsetenv("LCM_DEFAULT_URL"), 0);
}

TEST_F(ConfigTest, AFileOverridesAnyPartAndASettingOverridesTheFile) {
  const fs::path file = File("stereo:\n  max_disparity_px: 64\nodometry:\n  use_imu: false\nmapping:\n");
  const Config config = LoadConfig(file, {"stereo.max_disparity_px=96", "robot.self_mask_png="});
  EXPECT_EQ(config.pipeline.stereo.max_disparity_px, 96);
  EXPECT_FALSE(config.pipeline.odometry.use_imu);
  EXPECT_TRUE(config.pipeline.odometry.use_priors);
}

TEST_F(ConfigTest, TellsWhatComesTwiceOrCannotBeMeant) {
  EXPECT_THAT(ErrorOf(File("stereo:\n  max_disparity_px: 64\n  max_disparity_px: 96\n"), {}),
              HasSubstr("'max_disparity_px' comes twice"));
  EXPECT_THAT(ErrorOf({}, {"robot.body_height_m=400"}), HasSubstr("body_height_m = 400"));
  EXPECT_THAT(ErrorOf({}, {"robot.max_step_height_m=20"}), HasSubstr("max_step_height_m = 20"));
}

TEST_F(ConfigTest, ListsEveryProblemAtOnceWithFileLineKeyValueAndRule) {
  const fs::path file = File(
      "stereo:\n"
      "  max_disparity_px: lots\n"
      "  colour: blue\n"
      "robots:\n"
      "  legs: 6\n"
      "pipeline:\n"
      "  feedback_lag_frames: 99\n"
      "mapping: 3\n");
  const std::string error = ErrorOf(file, {"odometry.use_imu=perhaps", "nonsense"});
  const std::string name = file.string();
  EXPECT_THAT(error, HasSubstr(name + ":2: stereo.max_disparity_px = lots must be a whole number"));
  EXPECT_THAT(error, HasSubstr(name + ":3: there is no key 'stereo.colour'"));
  EXPECT_THAT(error, HasSubstr(name + ":4: there is no section 'robots'"));
  EXPECT_THAT(error, HasSubstr(name + ":7: pipeline.feedback_lag_frames = 99 must lie between 1 and 16"));
  EXPECT_THAT(error, HasSubstr(name + ":8: section 'mapping' must hold keys"));
  EXPECT_THAT(error,
              HasSubstr("--set odometry.use_imu=perhaps: odometry.use_imu = perhaps must be true or false"));
  EXPECT_THAT(error, HasSubstr("--set nonsense: must read section.key=value"));
}

TEST_F(ConfigTest, EveryComplaintNamesKeyValueAndRule) {
  const std::string error =
      ErrorOf({}, {"camera.scale=0.3", "stereo.rectified_focal_px=3", "camera.mounting.yaw_deg=270",
                   "stereo.paths=3", "stereo.edge_step_penalty=1", "odometry.num_cells=1",
                   "mapping.leaves_per_cell=10", "mapping.max_depth_sigma_m=0", "merging.max_angle_deg=50",
                   "labeling.min_upright_deg=20", "staircases.min_riser_m=0.5", "robot.max_ramp_slope_deg=70",
                   "robot.self_boxes_m=[1, 2]", "robot.self_mask_pixels=body", "lcm.url=here",
                   "lcm.imu_gap_ms=0", "channels.imu=IMU.*", "modelling.max_planes=0"});
  std::istringstream lines(error);
  int num_complaints = 0;
  for (std::string line; std::getline(lines, line); ++num_complaints)
    EXPECT_THAT(line, testing::MatchesRegex("--set .*: [a-z_.0-9]+ = .+ must .+")) << line;
  EXPECT_EQ(num_complaints, 18);
}

TEST_F(ConfigTest, SaysWhereAFileHasAKeyThatIsNoSettingAnyMore) {
  EXPECT_THAT(ErrorOf(File("robot:\n  body_height_m: 0.4\n  foot_radius_m: 0.03\n"), {}),
              HasSubstr("robot.yaml:3: there is no key 'robot.foot_radius_m'"));
}

TEST_F(ConfigTest, ReadsSectionsWithinSections) {
  const fs::path file =
      File("camera:\n  mounting:\n    source: body\n    pitch_deg: 20\n    position_m: [0.3, 0, 0.1]\n");
  const Config config = LoadConfig(file, {"camera.mounting.roll_deg=90"});
  EXPECT_EQ(config.pipeline.mounting.source, "body");
  EXPECT_EQ(config.pipeline.mounting.pitch_deg, 20.0);
  EXPECT_EQ(config.pipeline.mounting.roll_deg, 90.0);
  EXPECT_FALSE(config.pipeline.mounting.yaw_deg);
  EXPECT_EQ(config.pipeline.mounting.position_m, (std::vector<double>{0.3, 0.0, 0.1}));
  const std::string printed = PrintConfig(config);
  EXPECT_EQ(PrintConfig(LoadConfig(File(printed), {})), printed);
  const std::string error =
      ErrorOf(File("camera:\n  mounting:\n    source: floor\n    colour: blue\n  lens: 3\n"), {});
  EXPECT_THAT(error, HasSubstr(":3: camera.mounting.source = \"floor\" must be auto, body or sensor"));
  EXPECT_THAT(error, HasSubstr(":4: there is no key 'camera.mounting.colour'"));
  EXPECT_THAT(error, HasSubstr(":5: there is no key 'camera.lens'"));
  EXPECT_THAT(ErrorOf({}, {"camera.mounting.position_m=3"}), HasSubstr("must be a list of numbers"));
}

TEST_F(ConfigTest, SaysWhenAFileIsMissingOrNotYaml) {
  EXPECT_THAT(ErrorOf(dir_ / "none.yaml", {}), HasSubstr("none.yaml: cannot be read"));
  EXPECT_THAT(ErrorOf(dir_, {}), HasSubstr(": cannot be read"));
  EXPECT_THAT(ErrorOf(File("stereo: [1, 2\n"), {}), HasSubstr("is not YAML"));
  EXPECT_THAT(ErrorOf(File("just a word\n"), {}), HasSubstr("must hold sections"));
}

TEST_F(ConfigTest, RefusesNumbersThatAreNone) {
  EXPECT_THAT(ErrorOf({}, {"robot.body_height_m=.nan"}), HasSubstr("must be a number"));
  EXPECT_THAT(ErrorOf({}, {"robot.body_height_m=.inf"}), HasSubstr("must be a number"));
  EXPECT_THAT(ErrorOf({}, {"robot.body_height_m=[1]"}), HasSubstr("a list or a map must be a number"));
}

TEST_F(ConfigTest, EveryKeyIsPrintedBelowItsDocumentation) {
  std::istringstream printed(PrintConfig(Config{}));
  std::string before;
  int num_keys = 0;
  for (std::string line; std::getline(printed, line); before = line) {
    const std::size_t first = line.find_first_not_of(' ');
    if (line.substr(0, 2) != "  " || line[first] == '#' || line.back() == ':') continue;
    ++num_keys;
    EXPECT_EQ(before.substr(0, 2), "  ")
        << "neither documented nor sharing its neighbour's documentation: " << line;
  }
  EXPECT_GT(num_keys, 20);
}

TEST_F(ConfigTest, WhatItPrintsReadsBackAsTheSame) {
  const Config config =
      LoadConfig({}, {"stereo.max_disparity_px=96", "lcm.url=memq://\"", "robot.body_height_m=0.5"});
  const std::string printed = PrintConfig(config);
  EXPECT_EQ(PrintConfig(LoadConfig(File(printed), {})), printed);
  EXPECT_EQ(ConfigHash(LoadConfig(File(printed), {})), ConfigHash(config));
  EXPECT_NE(ConfigHash(LoadConfig({}, {})), ConfigHash(config));
}

TEST_F(ConfigTest, EveryShippedFileCanBeUsedAndTheDefaultFileIsWhatIsPrinted) {
  int num_files = 0;
  for (const auto& entry : fs::directory_iterator(TERRACE_CONFIG_DIR)) {
    if (entry.path().extension() != ".yaml") continue;
    ++num_files;
    EXPECT_EQ(ErrorOf(entry.path(), {}), "") << entry.path();
  }
  EXPECT_GE(num_files, 1);
  std::stringstream shipped;
  shipped << std::ifstream(fs::path(TERRACE_CONFIG_DIR) / "terraced.yaml").rdbuf();
  EXPECT_EQ(shipped.str(), PrintConfig(Config{}))
      << "write daemon/config/terraced.yaml anew: terraced --print-config > daemon/config/terraced.yaml";
}

}  // namespace
}  // namespace terrace
