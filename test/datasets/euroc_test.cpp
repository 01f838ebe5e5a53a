// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/euroc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class EurocTest : public testing::Test {
 protected:
  EurocTest() { WriteSmallEuroc(path()); }

  fs::path path() const { return folder_.path(); }
  fs::path mav() const { return path() / "mav0"; }

  void Replace(const fs::path& file, const std::string& from, const std::string& to) {
    std::string text = ReadTextFile(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    WriteText(file, text.replace(at, from.size(), to));
  }

  std::string Problem() {
    try {
      OpenEurocSequence(path());
    } catch (const SequenceError& error) {
      return error.what();
    }
    return "";
  }

  std::vector<SensorFrame> ReadAll(Sequence& sequence) {
    std::vector<SensorFrame> frames;
    while (std::optional<SensorFrame> frame = sequence.Next()) frames.push_back(std::move(*frame));
    return frames;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(EurocTest, ReadsCalibrationInBodyAxes) {
  const auto sequence = OpenEurocSequence(path());
  const StereoCalibration& calibration = sequence->info().calibration;
  EXPECT_EQ(calibration.width, 32);
  EXPECT_EQ(calibration.height, 24);
  EXPECT_EQ(calibration.left.fx, 30.0);
  EXPECT_EQ(calibration.left.cy, 11.5);
  EXPECT_TRUE(calibration.rectified());
  EXPECT_TRUE(calibration.T_rawright_rawleft.translation().isApprox(Eigen::Vector3d(-0.1, 0, 0)));
  ASSERT_TRUE(calibration.T_body_rawleft);
  // What lies one metre before the left camera is 1.2 m before the body.
  EXPECT_TRUE(
      (*calibration.T_body_rawleft * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1.2, 0.05, 0.1)));
  ASSERT_TRUE(calibration.T_body_imu);
  EXPECT_EQ(calibration.imu_noise.gyro_density, 1.7e-4);
}

TEST_F(EurocTest, DeliversFramesInOrderWithTheSamplesUpToThem) {
  const auto sequence = OpenEurocSequence(path());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.kind, SequenceKind::kEuroc);
  EXPECT_EQ(info.num_frames, kSmallFrames);
  EXPECT_EQ(info.t_first.ns, SmallTime(0));
  EXPECT_EQ(info.t_last.ns, SmallTime(3));
  EXPECT_TRUE(info.has_imu && info.has_attitude && info.has_legs && info.has_true_poses);
  EXPECT_THAT(info.warnings, IsEmpty());
  const std::vector<SensorFrame> frames = ReadAll(*sequence);
  ASSERT_EQ(frames.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const SensorFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.frame_id, i);
    EXPECT_EQ(frame.pair.t_capture.ns, SmallTime(i));
    EXPECT_EQ(frame.pair.problem, "");
    EXPECT_EQ(frame.pair.left.data, SmallImage(2 * i).data);
    EXPECT_EQ(frame.pair.right.data, SmallImage(2 * i + 1).data);
    // The IMU starts 50 ms before the first frame and runs at 50 Hz.
    EXPECT_EQ(frame.samples.imu.size(), i == 0 ? 3u : 5u);
    EXPECT_EQ(frame.samples.priors.size(), i == 0 ? 6u : 10u);
    for (const ImuSample& sample : frame.samples.imu) EXPECT_LE(sample.t, frame.pair.t_capture);
  }
  const BodyPrior& attitude = frames[0].samples.priors[0];
  EXPECT_EQ(attitude.kind, PriorKind::kAttitude);
  EXPECT_NEAR(attitude.covariance(1, 1), 0.02 * 0.02, 1e-15);
  const BodyPrior& legs = frames[0].samples.priors[1];
  EXPECT_EQ(legs.kind, PriorKind::kLegOdometry);
  EXPECT_TRUE((legs.T_odom_body * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0, 1, 0.4), 1e-6));
  EXPECT_NEAR(legs.covariance(5, 5), 0.003 * 0.003, 1e-15);
}

TEST_F(EurocTest, ReadsImuReadingsAsStored) {
  const auto sequence = OpenEurocSequence(path());
  const std::optional<SensorFrame> frame = sequence->Next();
  ASSERT_TRUE(frame);
  const ImuSample& sample = frame->samples.imu.at(1);
  EXPECT_EQ(sample.t.ns, SmallTime(0) - 30'000'000);
  EXPECT_TRUE(sample.gyro.isApprox(Eigen::Vector3d(0.1, 0.2, 0.01)));
  EXPECT_TRUE(sample.accel.isApprox(Eigen::Vector3d(0, 0, 9.81)));
}

TEST_F(EurocTest, PairsImagesWithinHalfAMillisecondAndReportsTheOthers) {
  const std::string t1 = std::to_string(SmallTime(1));
  const std::string t2 = std::to_string(SmallTime(2));
  Replace(mav() / "cam1" / "data.csv", t1 + ",", std::to_string(SmallTime(1) + 400'000) + ",");
  Replace(mav() / "cam1" / "data.csv", t2 + ",", std::to_string(SmallTime(2) + 600'000) + ",");
  const std::vector<SensorFrame> frames = ReadAll(*OpenEurocSequence(path()));
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[1].pair.problem, "");
  EXPECT_EQ(frames[1].pair.t_capture.ns, SmallTime(1));
  EXPECT_THAT(frames[2].pair.problem,
              AllOf(HasSubstr("cam1/data.csv"), HasSubstr("no right image within 0.5 ms"), HasSubstr(t2)));
  EXPECT_THAT(frames[3].pair.problem,
              AllOf(HasSubstr("cam0/data.csv"), HasSubstr("no left image within 0.5 ms")));
  EXPECT_EQ(frames[3].frame_id, 3);
  EXPECT_EQ(frames[4].pair.problem, "");
}

TEST_F(EurocTest, ReportsABadFrameInTheMiddleAndGoesOn) {
  const fs::path left = mav() / "cam0" / "data";
  WriteText(left / (std::to_string(SmallTime(1)) + ".png"), "no picture");
  WritePng(mav() / "cam1" / "data" / (std::to_string(SmallTime(2)) + ".png"), SmallImage(0, 16, 24));
  const std::vector<SensorFrame> frames = ReadAll(*OpenEurocSequence(path()));
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_THAT(frames[1].pair.problem, HasSubstr(".png: neither PNG nor JPEG"));
  EXPECT_TRUE(frames[1].pair.left.empty() && frames[1].pair.right.empty());
  EXPECT_EQ(frames[1].samples.imu.size(), 5u);
  EXPECT_THAT(frames[2].pair.problem,
              AllOf(HasSubstr("image of 16x24, must be 32x24"), HasSubstr("sensor.yaml")));
  EXPECT_EQ(frames[3].pair.problem, "");
}

TEST_F(EurocTest, LeavesOutAndCountsImagesWhoseTimeDoesNotRise) {
  for (const char* camera : {"cam0", "cam1"}) {
    const fs::path csv = mav() / camera / "data.csv";
    WriteText(csv, ReadTextFile(csv) + std::to_string(SmallTime(1)) + ",again.png\n");
  }
  const auto sequence = OpenEurocSequence(path());
  EXPECT_EQ(ReadAll(*sequence).size(), 4u);
  EXPECT_EQ(sequence->num_time_jumps(), 2);
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("cam0/data.csv: 1 image left out: time stamps must rise"),
                          HasSubstr("cam1/data.csv")));
}

TEST_F(EurocTest, SortsAListWhoseRowsAreNotInTheOrderOfTheirTimes) {
  const auto plain = ReadAll(*OpenEurocSequence(path()));
  const fs::path csv = mav() / "cam0" / "data.csv";
  std::string lines = ReadTextFile(csv);
  const std::string third = std::to_string(SmallTime(2));
  const std::size_t begin = lines.find(third), end = lines.find('\n', begin) + 1;
  const std::string row = lines.substr(begin, end - begin);
  WriteText(csv, lines.erase(begin, end - begin) + row);
  const auto sequence = OpenEurocSequence(path());
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("cam0/data.csv: 1 image not in the order of their times: sorted")));
  const std::vector<SensorFrame> sorted = ReadAll(*sequence);
  ASSERT_EQ(sorted.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(sorted[i].pair.t_capture, plain[i].pair.t_capture);
    EXPECT_EQ(sorted[i].pair.left.data, plain[i].pair.left.data);
    EXPECT_EQ(sorted[i].pair.problem, "");
  }
}

TEST_F(EurocTest, SkipsGarbageLinesWithAWarning) {
  Replace(mav() / "cam0" / "data.csv", "#timestamp [ns],filename\n", "#timestamp\n123,a.png\nx\x01y\n");
  const auto sequence = OpenEurocSequence(path());
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("cam0/data.csv: 1 line left out, the first is line 3")));
}

TEST_F(EurocTest, NamesEveryMissingFileAtOnce) {
  fs::remove_all(mav() / "cam1");
  fs::remove(mav() / "cam0" / "data.csv");
  EXPECT_THAT(Problem(),
              AllOf(HasSubstr("cam0/data.csv: no such file"), HasSubstr("cam1/data.csv: no such file"),
                    HasSubstr("cam1/sensor.yaml: no such file")));
}

TEST_F(EurocTest, NamesAnEmptyImageList) {
  WriteText(mav() / "cam0" / "data.csv", "#timestamp [ns],filename\n");
  EXPECT_THAT(Problem(), HasSubstr("cam0/data.csv: no line holds a time stamp [ns] and a file name"));
  WriteText(mav() / "cam0" / "data.csv", "");
  EXPECT_THAT(Problem(), HasSubstr("cam0/data.csv: no line holds"));
}

TEST_F(EurocTest, NamesCamerasThatNeverFireTogether) {
  std::string csv;
  for (int i = 0; i < 4; ++i) csv += std::to_string(SmallTime(i) + 50'000'000) + ",a.png\n";
  WriteText(mav() / "cam1" / "data.csv", csv);
  EXPECT_THAT(Problem(), HasSubstr("lie within 0.5 ms"));
}

TEST_F(EurocTest, RefusesSenselessCalibrationWithFileAndRule) {
  const fs::path left = mav() / "cam0" / "sensor.yaml";
  const std::string good = ReadTextFile(left);
  const struct {
    const char* from;
    const char* to;
    const char* problem;
  } cases[] = {
      {"intrinsics: [30.0, 30.0,", "intrinsics: [3e5, 30.0,", "fx = 300000 px is outside the image's scale"},
      {"intrinsics: [30.0, 30.0,", "intrinsics: [30.0,",
       "cam0/sensor.yaml: intrinsics must be a list of 4 numbers"},
      {"intrinsics: [30.0, 30.0,", "intrinsics: [.nan, 30.0,", "intrinsics must be a list of 4 numbers"},
      {"intrinsics: [30.0, 30.0,", "intrinsics: [a, 30.0,", "intrinsics must be a list of 4 numbers"},
      {"resolution: [32, 24]", "resolution: [32.5, 24]", "resolution must be two whole numbers"},
      {"resolution: [32, 24]", "resolution: [1e9, 24]", "must lie within 16x16 and 16384x16384"},
      {"resolution: [32, 24]", "resolution: [-32, 24]", "resolution must be two whole numbers"},
      {"resolution: [32, 24]", "", "cam0/sensor.yaml: resolution must be a list of 2 numbers"},
      {"resolution: [32, 24]", "resolution: [32, 24]\nresolution: [40, 24]", "'resolution' comes twice"},
      {"resolution: [32, 24]", "resolution: [40, 24]", "resolution differs from that of cam0"},
      {"radial-tangential", "wobbly",
       "distortion_model is wobbly, must be radial-tangential, equidistant or none"},
      {"pinhole", "omni", "camera_model is omni, must be pinhole"},
      {"0.050000", "-0.150000", "are left and right swapped?"},
      {"0.050000", "-0.050000", "baseline of 0 m must lie between"},
      {"[0, 0, 1, 0.2", "[0, 0, 2, 0.2", "T_BS must be a rotation and a translation"},
      {"T_BS:", "T_XX:", "T_BS: data must be a list of 16 numbers"},
      {"T_BS:", "T_BS: {{", "cam0/sensor.yaml: not valid YAML"},
      {"distortion_coefficients: [0.0, 0.0, 0.0, 0.0]", "distortion_coefficients: []",
       "must be a list of 1 to 14 numbers"},
  };
  for (const auto& c : cases) {
    WriteText(left, good);
    Replace(left, c.from, c.to);
    EXPECT_THAT(Problem(), HasSubstr(c.problem)) << c.to;
  }
  WriteText(left, "just a word");
  EXPECT_THAT(Problem(), HasSubstr("cam0/sensor.yaml: must be a YAML map"));
}

TEST_F(EurocTest, RefusesImagesOfAnotherSizeThanCalibrated) {
  for (const char* camera : {"cam0", "cam1"}) Replace(mav() / camera / "sensor.yaml", "[32, 24]", "[32, 30]");
  EXPECT_THAT(Problem(), AllOf(HasSubstr("cam0/data/"), HasSubstr("cam1/data/"),
                               HasSubstr("image of 32x24, must be 32x30")));
}

TEST_F(EurocTest, RefusesAFolderWithoutAReadableImage) {
  fs::remove_all(mav() / "cam0" / "data");
  EXPECT_THAT(Problem(), HasSubstr(".png: no such file"));
}

TEST_F(EurocTest, GoesOnWithoutAnImuThatCannotBeUsed) {
  WriteText(mav() / "imu0" / "data.csv", "#timestamp\n");
  auto sequence = OpenEurocSequence(path());
  EXPECT_FALSE(sequence->info().has_imu);
  EXPECT_THAT(sequence->info().warnings, ElementsAre(HasSubstr("imu0/data.csv: no line holds")));
  WriteSmallEuroc(path());
  fs::remove(mav() / "imu0" / "sensor.yaml");
  sequence = OpenEurocSequence(path());
  EXPECT_FALSE(sequence->info().has_imu);
  EXPECT_FALSE(sequence->info().calibration.T_body_imu);
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("imu0/sensor.yaml: no such file; the IMU is not used")));
}

TEST_F(EurocTest, NeedsNeitherImuNorPriorsNorTruth) {
  for (const char* sensor : {"imu0", "attitude0", "legs0", "state_groundtruth_estimate0"})
    fs::remove_all(mav() / sensor);
  const auto sequence = OpenEurocSequence(path());
  const SequenceInfo& info = sequence->info();
  EXPECT_FALSE(info.has_imu || info.has_attitude || info.has_legs || info.has_true_poses);
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_EQ(ReadAll(*sequence).size(), 4u);
}

TEST_F(EurocTest, ReadsAnEquidistantLensAndOpenCvsHeading) {
  for (const char* camera : {"cam0", "cam1"}) {
    Replace(mav() / camera / "sensor.yaml", "sensor_type", "%YAML:1.0\nsensor_type");
    Replace(mav() / camera / "sensor.yaml", "radial-tangential", "equidistant");
  }
  const auto sequence = OpenEurocSequence(path());
  EXPECT_EQ(sequence->info().calibration.right.model, DistortionModel::kEquidistant);
  EXPECT_FALSE(sequence->info().calibration.rectified());
}

}  // namespace
}  // namespace terrace
