// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "core/file_bytes.h"
#include "core/lens.h"
#include "datasets/rig_file.h"
#include "datasets/sequence.h"
#include "stereo/rectifier.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Small files as each tool writes them; the numbers are made up, and the same rig wherever a format can hold
// it: two cameras of 640x480, the right one 0.12 m to the right.

class CalibrationFileTest : public testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& text) {
    WriteText(folder_.path() / name, text);
    return folder_.path() / name;
  }
  RigReading Read(const std::string& name, const std::string& text, const RigOptions& options = {}) {
    return ReadCalibrationFiles({Write(name, text)}, options);
  }
  std::string Problem(const std::string& name, const std::string& text) {
    try {
      Read(name, text);
    } catch (const SequenceError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

void ExpectOurRig(const RigReading& reading, DistortionModel model, std::size_t num_coefficients) {
  EXPECT_THAT(reading.problems, IsEmpty());
  EXPECT_THAT(reading.missing, IsEmpty());
  ASSERT_TRUE(reading.rig);
  const StereoCalibration& rig = *reading.rig;
  EXPECT_EQ(rig.width, 640);
  EXPECT_EQ(rig.height, 480);
  EXPECT_EQ(rig.left.fx, 400.5);
  EXPECT_EQ(rig.left.fy, 401.5);
  EXPECT_EQ(rig.left.cx, 318.5);
  EXPECT_EQ(rig.right.cy, 241.5);
  EXPECT_EQ(rig.left.model, model);
  EXPECT_EQ(rig.left.distortion.size(), num_coefficients);
  EXPECT_TRUE(rig.T_rawright_rawleft.translation().isApprox(Eigen::Vector3d(-0.12, 0, 0), 1e-6));
  EXPECT_TRUE(rig.T_rawright_rawleft.linear().isIdentity(1e-6));
}

std::string KalibrCamera(int index, const std::string& model, const std::string& more) {
  const std::string centre = index == 0 ? "318.5, 239.5" : "322.5, 241.5";
  const std::string before = model == "omni"   ? "1.2, "
                             : model == "ds"   ? "-0.2, 0.6, "
                             : model == "eucm" ? "0.6, 1.1, "
                                               : "";
  return "cam" + std::to_string(index) + ":\n  cam_overlaps: [" + std::to_string(1 - index) +
         "]\n  camera_model: " + model + "\n  intrinsics: [" + before + "400.5, 401.5, " + centre +
         "]\n  resolution: [640, 480]\n" + more + "  rostopic: /cam/image_raw\n";
}

const std::string kKalibrChain =
    "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.12]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n"
    "  - [0.0, 0.0, 0.0, 1.0]\n";

TEST_F(CalibrationFileTest, ReadsKalibrsModelsAndChain) {
  const struct {
    const char* camera;
    const char* distortion;
    const char* coefficients;
    DistortionModel model;
    std::size_t count;
  } cases[] = {
      {"pinhole", "radtan", "[-0.1, 0.02, 0.001, 0.0]", DistortionModel::kRadialTangential, 4},
      {"pinhole", "equidistant", "[-0.01, 0.02, 0.001, 0.0]", DistortionModel::kEquidistant, 4},
      {"pinhole", "fov", "[0.9]", DistortionModel::kFieldOfView, 1},
      {"pinhole", "none", "[]", DistortionModel::kRadialTangential, 0},
      {"omni", "radtan", "[-0.1, 0.02, 0.001, 0.0]", DistortionModel::kOmni, 5},
      {"ds", "none", "[]", DistortionModel::kDoubleSphere, 2},
      {"eucm", "none", "[]", DistortionModel::kExtendedUnified, 2},
  };
  for (const auto& c : cases) {
    const std::string lens = std::string("  distortion_model: ") + c.distortion +
                             "\n  distortion_coeffs: " + c.coefficients + "\n";
    const RigReading reading = Read(
        "camchain.yaml", KalibrCamera(0, c.camera, lens) + KalibrCamera(1, c.camera, lens + kKalibrChain));
    ExpectOurRig(reading, c.model, c.count);
    EXPECT_EQ(reading.format, "Kalibr camchain");
    EXPECT_FALSE(reading.rig->T_body_rawleft);
  }
  EXPECT_THAT(Problem("camchain.yaml", KalibrCamera(0, "pinhole", "  distortion_model: wobbly\n")),
              AllOf(HasSubstr("camchain.yaml: cam0"), HasSubstr("distortion_model is wobbly")));
}

TEST_F(CalibrationFileTest, ReadsKalibrsImuAndClock) {
  const std::string pose_0 =
      "  T_cam_imu:\n  - [0.0, -1.0, 0.0, 0.01]\n  - [0.0, 0.0, -1.0, 0.02]\n  - [1.0, 0.0, 0.0, 0.03]\n"
      "  - [0.0, 0.0, 0.0, 1.0]\n  timeshift_cam_imu: 0.004\n";
  std::string pose_1 = pose_0;
  pose_1.replace(pose_1.find("0.01"), 4, "-0.11");
  const RigReading reading =
      Read("chain.yaml", KalibrCamera(0, "pinhole", pose_0) + KalibrCamera(1, "pinhole", pose_1));
  ExpectOurRig(reading, DistortionModel::kRadialTangential, 0);
  EXPECT_EQ(reading.imu_minus_camera_s, 0.004);
  // The IMU is the body: x ahead, z up.
  ASSERT_TRUE(reading.rig->T_body_rawleft && reading.rig->T_body_imu);
  EXPECT_TRUE((*reading.rig->T_body_rawleft * Eigen::Vector3d(0.01, 0.02, 0.03)).isZero(1e-12));
  EXPECT_TRUE(reading.rig->T_body_imu->matrix().isIdentity(1e-12));
}

TEST_F(CalibrationFileTest, SaysWhatIsMissingForARig) {
  const RigReading one = Read("camchain.yaml", KalibrCamera(0, "pinhole", ""));
  EXPECT_FALSE(one.rig);
  EXPECT_EQ(one.cameras.size(), 1u);
  EXPECT_THAT(one.missing,
              ElementsAre(HasSubstr("the other camera"), HasSubstr("how the cameras stand to each other")));
  RigOptions parallel;
  parallel.baseline_m = 0.12;
  const std::string two = KalibrCamera(0, "pinhole", "") + KalibrCamera(1, "pinhole", "");
  EXPECT_FALSE(Read("two.yaml", two).rig);
  ExpectOurRig(Read("two.yaml", two, parallel), DistortionModel::kRadialTangential, 0);
}

std::string OpenCvMatrix(const std::string& name, int rows, int columns, const std::string& data) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
}
const std::string kIdentity = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
const std::string kLeftMatrix = "4.005e+02, 0., 318.5, 0., 401.5, 239.5, 0., 0., 1.";
const std::string kRightMatrix = "4.005e+02, 0., 322.5, 0., 401.5, 241.5, 0., 0., 1.";

TEST_F(CalibrationFileTest, ReadsOpenCvsFilesWithAnyNumberOfCoefficientsAndUnit) {
  for (const int count : {4, 5, 8, 12, 14}) {
    std::string zeros = "-0.1";
    for (int i = 1; i < count; ++i) zeros += ", 0.";
    const std::string intrinsics =
        "%YAML:1.0\n---\n" + OpenCvMatrix("M1", 3, 3, kLeftMatrix) + OpenCvMatrix("D1", 1, count, zeros) +
        OpenCvMatrix("M2", 3, 3, kRightMatrix) + OpenCvMatrix("D2", 1, count, zeros);
    for (const auto& [t, unit] :
         {std::pair{"-0.12, 0., 0.", "metres"}, std::pair{"-12., 0., 0.", "centimetres"},
          std::pair{"-120., 0., 0.", "millimetres"}}) {
      const std::string extrinsics =
          "%YAML:1.0\n" + OpenCvMatrix("R", 3, 3, kIdentity) + OpenCvMatrix("T", 3, 1, t);
      const RigReading reading =
          ReadCalibrationFiles({Write("intrinsics.yml", intrinsics), Write("extrinsics.yml", extrinsics)});
      ExpectOurRig(reading, DistortionModel::kRadialTangential, static_cast<std::size_t>(count));
      std::string notes;
      for (const std::string& note : reading.notes) notes += note + "\n";
      EXPECT_THAT(notes, HasSubstr("640x480 is taken"));
      if (std::string(unit) != "metres") {
        EXPECT_THAT(notes, HasSubstr(unit));
      }
    }
  }
}

TEST_F(CalibrationFileTest, ReadsOpenCvsFisheyeInFilesOfOneCamera) {
  const auto camera = [](const std::string& K) {
    return "%YAML:1.0\nimage_width: 640\nimage_height: 480\nfisheye_model: 1\n" +
           OpenCvMatrix("camera_matrix", 3, 3, K) +
           OpenCvMatrix("distortion_coefficients", 4, 1, "-0.01, 0.002, 0., 0.");
  };
  const std::string pose = "%YAML:1.0\n" + OpenCvMatrix("rotation_matrix", 3, 3, kIdentity) +
                           OpenCvMatrix("translation_vector", 3, 1, "-0.12, 0., 0.");
  // Names tell the sides, whatever the order.
  const RigReading reading =
      ReadCalibrationFiles({Write("my-right.yml", camera(kRightMatrix)), Write("both.yml", pose),
                            Write("my-left.yml", camera(kLeftMatrix))});
  ExpectOurRig(reading, DistortionModel::kEquidistant, 4);
}

TEST_F(CalibrationFileTest, ToldUnitAndSizeWin) {
  const std::string both = "%YAML:1.0\n" + OpenCvMatrix("K1", 3, 3, kLeftMatrix) +
                           OpenCvMatrix("K2", 3, 3, kRightMatrix) + OpenCvMatrix("R", 3, 3, kIdentity) +
                           OpenCvMatrix("T", 3, 1, "-12., 0., 0.");
  RigOptions options;
  options.unit_m = 1e-3;
  options.size = {648, 488};
  const RigReading reading = Read("stereo.yml", both, options);
  ASSERT_TRUE(reading.rig);
  EXPECT_NEAR(reading.rig->baseline_m(), 0.012, 1e-12);
  EXPECT_EQ(reading.rig->width, 648);
  EXPECT_THAT(reading.notes, IsEmpty());
}

std::string RosFile(const std::string& side, const std::string& centre, const std::string& shift) {
  return "image_width: 640\nimage_height: 480\ncamera_name: stereo/" + side +
         "\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [400.5, 0, " + centre.substr(0, 5) +
         ", 0, 401.5, " + centre.substr(7) +
         ", 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
         "  data: [-0.2, 0.06, 0.0, 0.0, 0.0]\nrectification_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
         "  data: [400.0, 0, 320, " +
         shift + ", 0, 400.0, 240, 0, 0, 0, 1, 0]\n";
}

TEST_F(CalibrationFileTest, ReadsPairsOfRosCameraInfo) {
  const RigReading reading = ReadCalibrationFiles({Write("a.yaml", RosFile("right", "322.5, 241.5", "-48.0")),
                                                   Write("b.yaml", RosFile("left", "318.5, 239.5", "0.0"))});
  ExpectOurRig(reading, DistortionModel::kRadialTangential, 5);
}

TEST_F(CalibrationFileTest, ReadsRosOstText) {
  const auto camera = [](const std::string& side, const std::string& K, const std::string& shift) {
    return "[narrow/" + side + "]\n\ncamera matrix\n" + K +
           "\ndistortion\n-0.2 0.06 0.0 0.0 0.0\n\nrectification\n" +
           "1 0 0\n0 1 0\n0 0 1\n\nprojection\n400.0 0 320 " + shift + "\n0 400.0 240 0\n0 0 1 0\n\n";
  };
  const RigReading reading =
      Read("ost.txt", "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n" +
                          camera("left", "400.5 0 318.5\n0 401.5 239.5\n0 0 1\n", "0") +
                          "# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n" +
                          camera("right", "400.5 0 322.5\n0 401.5 241.5\n0 0 1\n", "-48.0"));
  ExpectOurRig(reading, DistortionModel::kRadialTangential, 5);
}

TEST_F(CalibrationFileTest, TurnsNothingRoundInSilence) {
  // A right camera on the wrong side.
  const RigReading swapped = ReadCalibrationFiles({Write("a.yaml", RosFile("right", "322.5, 241.5", "48.0")),
                                                   Write("b.yaml", RosFile("left", "318.5, 239.5", "0.0"))});
  EXPECT_THAT(swapped.problems, ElementsAre(HasSubstr("are left and right swapped?")));
  // One camera upside down.
  std::string turned = RosFile("right", "322.5, 241.5", "-48.0");
  turned.replace(turned.find("[1, 0, 0, 0, 1, 0, 0, 0, 1]"), 27, "[-1, 0, 0, 0, -1, 0, 0, 0, 1]");
  const RigReading upside_down = ReadCalibrationFiles(
      {Write("a.yaml", turned), Write("b.yaml", RosFile("left", "318.5, 239.5", "0.0"))});
  EXPECT_THAT(upside_down.problems, ElementsAre(HasSubstr("turned by 180 deg about its optical axis")));
  // A model that its coefficients cannot mean.
  std::string other = RosFile("left", "318.5, 239.5", "0.0");
  other.replace(other.find("plumb_bob"), 9, "equidistant");
  other.replace(other.find("[-0.2, 0.06, 0.0, 0.0, 0.0]"), 27, "[11.3, -118.0, 540.0, -820.0]");
  const RigReading claims = ReadCalibrationFiles(
      {Write("a.yaml", RosFile("right", "322.5, 241.5", "-48.0")), Write("b.yaml", other)});
  EXPECT_THAT(claims.problems, ElementsAre(HasSubstr("belong to another model than equidistant")));
}

std::string EurocFile(double y_of_camera, const std::string& lens) {
  return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, 0, 1, 0.2, -1, 0, 0, " +
         std::to_string(y_of_camera) + ", 0, -1, 0, 0.1, 0, 0, 0, 1]\nresolution: [640, 480]\n" + lens;
}

TEST_F(CalibrationFileTest, ReadsEurocSensorFilesBySideOfTheirFolder) {
  const auto lens = [](const char* centre) {
    return std::string("camera_model: pinhole\nintrinsics: [400.5, 401.5, ") + centre +
           "]\ndistortion_model: radial-tangential\ndistortion_coefficients: [-0.2, 0.05, 0, 0]\n";
  };
  Write("mav0/cam0/sensor.yaml", EurocFile(0.06, lens("318.5, 239.5")));
  Write("mav0/cam1/sensor.yaml", EurocFile(-0.06, lens("322.5, 241.5")));
  const RigReading reading = ReadCalibrationFiles({folder_.path()});
  ExpectOurRig(reading, DistortionModel::kRadialTangential, 4);
  ASSERT_TRUE(reading.rig->T_body_rawleft);
  EXPECT_TRUE(reading.rig->T_body_rawleft->translation().isApprox(Eigen::Vector3d(0.2, 0.06, 0.1)));
}

TEST_F(CalibrationFileTest, ReadsTheOmniPolynomialOfAnEurocSensorFile) {
  const RigReading reading =
      Read("sensor.yaml",
           EurocFile(0.0,
                     "camera_model: omni\nintrinsics: []\ndistortion_model: omni\n"
                     "distortion_coefficients: [210.0, 0.0, -0.0012, -1.0e-6, 2.0e-9]\n"
                     "omni_affine: [0.001, -0.002, 1.003]\nomni_distortion_center: [321.0, 238.0]\n"));
  ASSERT_EQ(reading.cameras.size(), 1u);
  const Lens lens(reading.cameras[0].lens);
  for (const Eigen::Vector2d& m :
       {Eigen::Vector2d(10, 20), Eigen::Vector2d(-180, 90), Eigen::Vector2d(150, -160)}) {
    const double rho = m.norm();
    const double z = 210.0 - 0.0012 * rho * rho - 1e-6 * std::pow(rho, 3) + 2e-9 * std::pow(rho, 4);
    const auto pixel = lens.Project({m.x(), m.y(), z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), m.x() + 0.001 * m.y() + 321.0, 1e-7);
    EXPECT_NEAR(pixel->y(), -0.002 * m.x() + 1.003 * m.y() + 238.0, 1e-7);
  }
}

TEST_F(CalibrationFileTest, ReadsKittiRawOfBothKindsOfImage) {
  const auto camera = [](const char* i, const char* centre, const char* shift, const char* T) {
    const std::string n = i;
    return "S_" + n + ": 6.4e+02 4.8e+02\nK_" + n + ": 400.5 0 " + centre + " 0 0 1\nD_" + n +
           ": -0.3 0.1 0 0 0\nR_" + n + ": 1 0 0 0 1 0 0 0 1\nT_" + n + ": " + T + "\nS_rect_" + n +
           ": 600 440\nR_rect_" + n + ": 1 0 0 0 1 0 0 0 1\nP_rect_" + n + ": 380 0 300 " + shift +
           " 0 380 220 0 0 0 1 0\n";
  };
  const std::string text = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\n" +
                           camera("00", "318.5 0 401.5 239.5", "0", "0 0 0") +
                           camera("01", "322.5 0 401.5 241.5", "-45.6", "-0.12 0 0");
  ExpectOurRig(Read("calib_cam_to_cam.txt", text), DistortionModel::kRadialTangential, 5);
  RigOptions rectified;
  rectified.size = {600, 440};
  const RigReading reading = Read("calib_cam_to_cam.txt", text, rectified);
  ASSERT_TRUE(reading.rig);
  EXPECT_TRUE(reading.rig->rectified());
  EXPECT_NEAR(reading.rig->baseline_m(), 0.12, 1e-12);
}

TEST_F(CalibrationFileTest, ReadsKittiOdometry) {
  RigOptions options;
  options.size = {640, 480};
  const RigReading reading = Read(
      "calib.txt", "P0: 400 0 320 0 0 400 240 0 0 0 1 0\nP1: 400 0 320 -48 0 400 240 0 0 0 1 0\n", options);
  ASSERT_TRUE(reading.rig);
  EXPECT_NEAR(reading.rig->baseline_m(), 0.12, 1e-12);
  EXPECT_TRUE(reading.rig->rectified());
}

TEST_F(CalibrationFileTest, ReadsCamodocalCamerasBesideAVinsConfiguration) {
  const auto camera = [](const char* centre, bool mei) {
    return std::string("%YAML:1.0\n---\nmodel_type: ") + (mei ? "MEI" : "PINHOLE") +
           "\ncamera_name: camera\nimage_width: 640\nimage_height: 480\n" +
           (mei ? "mirror_parameters:\n   xi: 1.2\n" : "") +
           "distortion_parameters:\n   k1: -0.1\n   k2: 0.02\n   p1: 0.0\n   p2: "
           "0.001\nprojection_parameters:\n   " +
           (mei ? "gamma1" : "fx") + ": 400.5\n   " + (mei ? "gamma2" : "fy") + ": 401.5\n" + centre;
  };
  const std::string kPinholes[] = {camera("   cx: 318.5\n   cy: 239.5\n", false),
                                   camera("   cx: 322.5\n   cy: 241.5\n", false)};
  const std::string kMeis[] = {camera("   u0: 318.5\n   v0: 239.5\n", true),
                               camera("   u0: 322.5\n   v0: 241.5\n", true)};
  const std::string config =
      "%YAML:1.0\ncam0_calib: \"left.yaml\"\ncam1_calib: \"right.yaml\"\nacc_n: 0.1\ngyr_n: 0.01\n" +
      OpenCvMatrix("body_T_cam0", 4, 4, "1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1") +
      OpenCvMatrix("body_T_cam1", 4, 4, "1, 0, 0, 0.17, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1");
  for (const auto& [cameras, model, count] : {std::tuple{kPinholes, DistortionModel::kRadialTangential, 4u},
                                              std::tuple{kMeis, DistortionModel::kOmni, 5u}}) {
    Write("left.yaml", cameras[0]);
    Write("right.yaml", cameras[1]);
    const RigReading reading = Read("config.yaml", config);
    ExpectOurRig(reading, model, count);
    EXPECT_EQ(reading.rig->imu_noise.gyro_density, 0.01);
  }
}

TEST_F(CalibrationFileTest, ReadsBasalt) {
  const auto camera = [](const char* centre) {
    return std::string("{\"camera_type\": \"ds\", \"intrinsics\": {\"fx\": 400.5, \"fy\": 401.5, ") + centre +
           ", \"xi\": -0.2, \"alpha\": 0.6}}";
  };
  const auto pose = [](const char* x) {
    return std::string("{\"px\": ") + x +
           ", \"py\": 0, \"pz\": 0, \"qx\": 0, \"qy\": 0, \"qz\": 0, \"qw\": 1}";
  };
  const RigReading reading =
      Read("calibration.json",
           "{\n\t\"value0\": {\"T_imu_cam\": [" + pose("0.01") + "," + pose("0.13") + "], \"intrinsics\": [" +
               camera("\"cx\": 318.5, \"cy\": 239.5") + "," + camera("\"cx\": 322.5, \"cy\": 241.5") +
               "], \"resolution\": [[640, 480], [640, 480]], \"gyro_noise_std\": [0.001, 0.002, 0.001]}}\n");
  ExpectOurRig(reading, DistortionModel::kDoubleSphere, 2);
  EXPECT_EQ(reading.rig->imu_noise.gyro_density, 0.002);
}

TEST_F(CalibrationFileTest, ReadsAZedsFactoryFileInTheSizeOfTheImages) {
  const auto camera = [](const std::string& name, double scale, double cx, double cy) {
    return "[" + name + "]\nfx=" + std::to_string(400.5 * scale) + "\nfy=" + std::to_string(401.5 * scale) +
           "\ncx=" + std::to_string(cx * scale) + "\ncy=" + std::to_string(cy * scale) +
           "\nk1=-0.04\nk2=0.01\np1=0\np2=0\nk3=0\n\n";
  };
  std::string text;
  for (const auto& [name, scale] : {std::pair{"HD", 2.0}, std::pair{"VGA", 1.0}}) {
    text += camera(std::string("LEFT_CAM_") + name, scale, 336.5, 187.5) +
            camera(std::string("RIGHT_CAM_") + name, scale, 338.5, 189.5);
  }
  text +=
      "[STEREO]\nBaseline=120.0\nTY=0\nTZ=0\nCV_HD=0.01\nCV_VGA=0.01\nRX_HD=0\nRX_VGA=0.002\nRZ_HD=0\nRZ_VGA="
      "0\n";
  RigOptions options;
  options.size = {672, 376};
  const RigReading reading = Read("SN1234.conf", text, options);
  ASSERT_TRUE(reading.rig);
  EXPECT_THAT(reading.problems, IsEmpty());
  EXPECT_EQ(reading.rig->left.fx, 400.5);
  EXPECT_TRUE(reading.rig->T_rawright_rawleft.translation().isApprox(Eigen::Vector3d(-0.12, 0, 0)));
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(reading.rig->T_rawright_rawleft.linear()));
  EXPECT_NEAR(turn.angle(), std::hypot(0.01, 0.002), 1e-12);
  EXPECT_EQ(Read("SN1234.conf", text).rig->width, 1280);
}

TEST_F(CalibrationFileTest, ReadsTheTextOfARectifiedZed) {
  const RigReading reading = Read("calib.txt", "Pinhole 400 400 320 240 0\n640 480\ncrop\n640 480\n0.12\n");
  ASSERT_TRUE(reading.rig);
  EXPECT_TRUE(reading.rig->rectified());
  EXPECT_NEAR(reading.rig->baseline_m(), 0.12, 1e-12);
}

TEST_F(CalibrationFileTest, ReadsAnEconFileInMillimetres) {
  std::string text = "%YAML:1.0\nCamera.image_width: 640\nCamera.image_height: 480\nCamera.baseline: 120.0\n";
  for (const auto& [name, cx, cy] :
       {std::tuple{"Camera1", "318.5", "239.5"}, std::tuple{"Camera2", "322.5", "241.5"}}) {
    const std::string n = name;
    text += n + ".fx: 400.5\n" + n + ".fy: 401.5\n" + n + ".cx: " + cx + "\n" + n + ".cy: " + cy + "\n" + n +
            ".k1: 0.1\n" + n + ".k2: -0.2\n" + n + ".k3: 0.05\n" + n + ".p1: 0.0\n" + n + ".p2: 0.001\n";
  }
  const RigReading reading = Read("tara.yaml", text);
  ExpectOurRig(reading, DistortionModel::kRadialTangential, 5);
  EXPECT_EQ(reading.rig->left.distortion[4], 0.05);  // k3 comes last
}

TEST_F(CalibrationFileTest, ReadsAnOaksMemory) {
  const auto camera = [](const char* socket, const char* centre, const char* to, const char* x) {
    return std::string("[") + socket +
           ", {\"cameraType\": 0, \"distortionCoeff\": [0.1, -0.2, 0, 0, 0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0], " +
           "\"extrinsics\": {\"rotationMatrix\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"toCameraSocket\": " +
           to + ", \"translation\": {\"x\": " + x +
           ", \"y\": 0, \"z\": 0}}, \"height\": 480, \"intrinsicMatrix\": [[400.5, 0, " + centre +
           "], [0, 0, 1]], \"width\": 640}]";
  };
  const std::string text =
      "{\"boardName\": \"BW\", \"cameraData\": [" + camera("0", "320], [0, 401.5, 240", "-1", "0") + "," +
      camera("1", "318.5], [0, 401.5, 239.5", "2", "-12.0") + "," +
      camera("2", "322.5], [0, 401.5, 241.5", "0", "6.0") +
      "], \"stereoRectificationData\": {\"leftCameraSocket\": 1, \"rightCameraSocket\": 2}}";
  ExpectOurRig(Read("oak.json", text), DistortionModel::kRadialTangential, 14);
}

TEST_F(CalibrationFileTest, ReadsWhatTheRealSenseSdkPrints) {
  const auto stream = [](const char* name, const char* centre) {
    return std::string("\"") + name + "\": {\"width\": 640, \"height\": 480, " + centre +
           ", \"fx\": 400.5, \"fy\": 401.5, \"model\": \"distortion.brown_conrady\", \"coeffs\": [0, 0, 0, "
           "0, 0]}";
  };
  const std::string json = "{" + stream("infrared1", "\"ppx\": 318.5, \"ppy\": 239.5") + "," +
                           stream("infrared2", "\"ppx\": 322.5, \"ppy\": 241.5") + "," +
                           stream("color", "\"ppx\": 300, \"ppy\": 200") +
                           ", \"infrared1_to_infrared2\": {\"rotation\": [1, 0, 0, 0, 1, 0, 0, 0, 1], "
                           "\"translation\": [-0.12, 0, 0]}}";
  ExpectOurRig(Read("realsense.json", json), DistortionModel::kRadialTangential, 0);

  const auto block = [](const char* name, const char* size, const char* centre) {
    return std::string(" Intrinsic of \"") + name + "\" / " + size + " / {Y8}\n" + centre +
           "  Fx:         400.5\n  Fy:         401.5\n  Distortion: Brown Conrady\n  Coeffs:     0   0   0   "
           "0   0  \n"
           "  FOV (deg):   77.27 x 61.77\n\n";
  };
  const std::string text = "Intrinsic Parameters:\n\n" +
                           block("Infrared 1", "640x480",
                                 "  Width:       640\n  Height:     480\n  PPX:  318.5\n  PPY:  239.5\n") +
                           block("Infrared 2", "640x480",
                                 "  Width:       640\n  Height:     480\n  PPX:  322.5\n  PPY:  241.5\n") +
                           "Extrinsic Parameters:\n\nExtrinsic from \"Depth\"  To  \"Infrared 2\" :\n "
                           "Rotation Matrix:\n  1 0 0\n 0 1 0\n 0 0 1\n\n"
                           " Translation Vector: -0.5  0  0\n\nExtrinsic from \"Infrared 1\"\t  To\t  "
                           "\"Infrared 2\" :\n Rotation Matrix:\n"
                           "   1                0                0\n   0                1                0\n "
                           "  0                0                1\n\n"
                           " Translation Vector: -0.12  0  0\n\n";
  ExpectOurRig(Read("realsense.txt", text), DistortionModel::kRadialTangential, 0);
}

TEST_F(CalibrationFileTest, RigFilesReadBackExactly) {
  StereoCalibration rig;
  rig.name = "a \"quoted\" name";
  rig.width = 640;
  rig.height = 480;
  rig.left = {400.0 / 3.0, 134.5, 318.5, 239.5, DistortionModel::kDoubleSphere, {-0.1 / 3.0, 0.6}};
  rig.right = {133.0, 134.0, 322.5, 241.5, DistortionModel::kEquidistant, {0.01, 0, 0, 1e-17}};
  rig.T_rawright_rawleft.linear() =
      Eigen::AngleAxisd(0.013, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  rig.T_rawright_rawleft.translation() = Eigen::Vector3d(-0.12, 1.0 / 700.0, 1e-5);
  rig.T_body_rawleft = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0.06, 0.1));
  rig.T_body_imu = Eigen::Isometry3d(Eigen::Translation3d(0.01, 0, 0));
  rig.imu_noise = {1e-3, 1.0 / 3.0e5, 2e-3, 3e-5};
  const RigReading reading = Read("rig.yaml", PrintRigFile(rig));
  ASSERT_TRUE(reading.rig);
  EXPECT_THAT(reading.problems, IsEmpty());
  for (const auto& [a, b] :
       {std::pair{reading.rig->left, rig.left}, std::pair{reading.rig->right, rig.right}}) {
    EXPECT_EQ(a.fx, b.fx);
    EXPECT_EQ(a.cy, b.cy);
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.distortion, b.distortion);
  }
  EXPECT_EQ(reading.rig->T_rawright_rawleft.matrix(), rig.T_rawright_rawleft.matrix());
  EXPECT_EQ(reading.rig->T_body_rawleft->matrix(), rig.T_body_rawleft->matrix());
  EXPECT_EQ(reading.rig->T_body_imu->matrix(), rig.T_body_imu->matrix());
  EXPECT_EQ(reading.rig->imu_noise.gyro_walk, rig.imu_noise.gyro_walk);
  // And a rig file of what was read is the same file, but for the name.
  StereoCalibration again = *reading.rig;
  again.name = rig.name;
  EXPECT_EQ(PrintRigFile(again), PrintRigFile(rig));
}

TEST_F(CalibrationFileTest, RefusesWhatIsNoCalibration) {
  EXPECT_THAT(Problem("a.yaml", "just words"), HasSubstr("must be a calibration of Kalibr"));
  EXPECT_THAT(Problem("a.yaml", "{"), HasSubstr("not valid YAML"));
  EXPECT_THAT(Problem("a.yaml", "cam0: {fx: 1}\ncam1: {fx: 1, fx: 2}\n"), HasSubstr("'fx' comes twice"));
  EXPECT_THAT(Problem("a.yaml", "colour: blue\n"), HasSubstr("holds neither camera matrices"));
  EXPECT_THAT(Problem("a.json", "{\"a\": 1}"), HasSubstr("holds no intrinsics"));
  std::vector<std::string> notes;
  EXPECT_THROW(ReadRig({folder_.path() / "none.yaml"}, &notes), SequenceError);
}

TEST_F(CalibrationFileTest, SplitsListsOfFiles) {
  EXPECT_THAT(SplitFileList("left.yaml, right one.yaml ,"), ElementsAre("left.yaml", "right one.yaml"));
  EXPECT_THAT(SplitFileList(""), IsEmpty());
}

/// Rigs as people have them: every file is read, and all but those of one lying driver make sense.
TEST(CalibrationRecordingsTest, ReadsEveryFileThatPeopleHave) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA is not set";
  int num_files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(data) / "calibrations")) {
    const RigReading reading = ReadCalibrationFiles({entry.path()});
    const std::string name = entry.path().filename().string();
    const bool lies = name.find("claims-equidistant") != std::string::npos;
    EXPECT_EQ(reading.problems.empty(), !lies) << name;
    ++num_files;
  }
  EXPECT_EQ(num_files, 32);
}

/// Files that belong together, by the numbers that they begin with, and the model of their left lens.
struct RigOfPeople {
  std::vector<std::string> numbers;
  DistortionModel model;
};
const std::vector<RigOfPeople> kRigsOfPeople = {
    {{"02"}, DistortionModel::kEquidistant},
    {{"05"}, DistortionModel::kRadialTangential},
    {{"27"}, DistortionModel::kDoubleSphere},
    {{"29"}, DistortionModel::kExtendedUnified},
    {{"37", "38"}, DistortionModel::kRadialTangential},
    {{"45", "46"}, DistortionModel::kEquidistant},
    {{"48"}, DistortionModel::kRadialTangential},
    {{"49", "50"}, DistortionModel::kRadialTangential},
    {{"53", "54"}, DistortionModel::kRadialTangential},
    {{"55", "56", "57"}, DistortionModel::kRadialTangential},
    {{"58", "59"}, DistortionModel::kRadialTangential},
    {{"61"}, DistortionModel::kRadialTangential},
    {{"66"}, DistortionModel::kRadialTangential},
    {{"72"}, DistortionModel::kRadialTangential},
};

std::vector<fs::path> FilesOf(const RigOfPeople& rig, const fs::path& folder) {
  std::vector<fs::path> files;
  for (const std::string& number : rig.numbers)
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().filename().string().starts_with(number + "-")) files.push_back(entry.path());
  return files;
}

/// Where OpenCV sees a point; none: it knows no such lens.
std::optional<Eigen::Vector2d> SeenByOpenCv(const RawCamera& camera, const Eigen::Vector3d& p) {
  const std::vector<cv::Point3d> points = {{p.x(), p.y(), p.z()}};
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  if (camera.model == DistortionModel::kRadialTangential)
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, camera.distortion, pixels);
  else if (camera.model == DistortionModel::kEquidistant)
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), K, camera.distortion);
  else
    return std::nullopt;
  return Eigen::Vector2d(pixels[0].x, pixels[0].y);
}

/// A point of a pixel of the rectified pair, at some depth, has to be where OpenCV's lenses see it, and back
/// from there on its pixel. What OpenCV has no lens for is held against its own equations in lens_test.cpp.
TEST(CalibrationRecordingsTest, RectifiedRaysOfEveryRigAreThoseOfOpenCv) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA is not set";
  constexpr double kLargestErrorPx = 0.05;
  constexpr double kDepthM = 3.0;
  for (const RigOfPeople& people : kRigsOfPeople) {
    SCOPED_TRACE(people.numbers.front());
    const RigReading reading = ReadCalibrationFiles(FilesOf(people, fs::path(data) / "calibrations"));
    ASSERT_TRUE(reading.rig && reading.problems.empty());
    const StereoCalibration& rig = *reading.rig;
    EXPECT_EQ(rig.left.model, people.model);
    const Rectifier rectifier(rig);
    const StereoCamera& camera = rectifier.camera();
    const Lens left(rig.left), right(rig.right);
    int num_seen = 0;
    double worst_px = 0.0;
    for (int v = 0; v < camera.height; v += 40) {
      for (int u = 0; u < camera.width; u += 40) {
        const Eigen::Vector3d p_left = camera.Triangulate(u, v, camera.Disparity(kDepthM));
        const Eigen::Vector3d p_rawleft = rectifier.R_rect_raw().transpose() * p_left;
        const Eigen::Vector3d p_rawright = rig.T_rawright_rawleft * p_rawleft;
        const auto in_left = left.Project(p_rawleft), in_right = right.Project(p_rawright);
        const auto seen_left = SeenByOpenCv(rig.left, p_rawleft),
                   seen_right = SeenByOpenCv(rig.right, p_rawright);
        if (!in_left || !in_right) continue;
        ++num_seen;
        if (seen_left && seen_right)
          worst_px = std::max({worst_px, (*in_left - *seen_left).norm(), (*in_right - *seen_right).norm()});
        // And back: the two rays meet the rectified images on one row, a disparity apart.
        const auto ray_left = left.Unproject(*in_left), ray_right = right.Unproject(*in_right);
        ASSERT_TRUE(ray_left && ray_right);
        const Eigen::Matrix3d R_rect_rawright =
            rectifier.R_rect_raw() * rig.T_rawright_rawleft.linear().transpose();
        const Eigen::Vector3d a = rectifier.R_rect_raw() * *ray_left, b = R_rect_rawright * *ray_right;
        const Eigen::Vector2d pixel_a(camera.fx * a.x() / a.z() + camera.cx,
                                      camera.fy * a.y() / a.z() + camera.cy);
        const Eigen::Vector2d pixel_b(camera.fx * b.x() / b.z() + camera.cx,
                                      camera.fy * b.y() / b.z() + camera.cy);
        worst_px = std::max(worst_px, (pixel_a - Eigen::Vector2d(u, v)).norm());
        worst_px = std::max(worst_px, (pixel_b - Eigen::Vector2d(u - camera.Disparity(kDepthM), v)).norm());
      }
    }
    std::printf("%s: %.4f px at most over %d pixels\n", people.numbers.front().c_str(), worst_px, num_seen);
    EXPECT_GT(num_seen, 50);
    EXPECT_LE(worst_px, kLargestErrorPx);
  }
}

}  // namespace
}  // namespace terrace
