// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/opencv_xml.h"

#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "datasets/calibration_file.h"
#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

// As cv::FileStorage writes a stereo rig.
constexpr const char* kRigXml = R"(<?xml version="1.0"?>
<opencv_storage>
<!-- a rig -->
<calibration_time>"Mon Nov 30 01:02:03 2020"</calibration_time>
<image_width>640</image_width>
<image_height>480</image_height>
<M1 type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    4.0e+02 0. 3.195e+02 0. 4.1e+02
    2.395e+02 0. 0. 1.</data></M1>
<D1 type_id="opencv-matrix">
  <rows>1</rows>
  <cols>5</cols>
  <dt>d</dt>
  <data>
    -1.0e-01 1.0e-02 0. 0. 0.</data></D1>
<M2 type_id="opencv-matrix">
  <rows>3</rows> <cols>3</cols> <dt>d</dt>
  <data> 402. 0. 318. 0. 412. 238. 0. 0. 1.</data></M2>
<D2 type_id="opencv-matrix">
  <rows>1</rows> <cols>5</cols> <dt>d</dt>
  <data> -1.1e-01 1.1e-02 0. 0. 0.</data></D2>
<R type_id="opencv-matrix">
  <rows>3</rows> <cols>3</cols> <dt>d</dt>
  <data> 1. 0. 0. 0. 1. 0. 0. 0. 1.</data></R>
<T type_id="opencv-matrix">
  <rows>3</rows> <cols>1</cols> <dt>d</dt>
  <data> -1.2e-01 0. 0.</data></T>
</opencv_storage>
)";

TEST(OpenCvXmlTest, GivesKeysListsMatricesAndTexts) {
  EXPECT_EQ(
      YamlFromOpenCvXml("<?xml version=\"1.0\"?>\n<opencv_storage><a>1</a><b>1 2.5 "
                        "-3e-1</b><c><_>x</_><_>\"two words\"</_></c>"
                        "<d type_id=\"opencv-matrix\"><rows>1</rows><data>7</data></d><e></e><f/><g>a&amp;b: "
                        "c</g></opencv_storage>",
                        "f.xml"),
      "{a: 1, b: [1, 2.5, -3e-1], c: [x, \"two words\"], d: {rows: 1, data: [7]}, e: \"\", f: \"\", g: "
      "[\"a&b:\", c]}");
}

TEST(OpenCvXmlTest, ReadsARigAsTheYamlOfTheSameProgram) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "rig.xml") << kRigXml;
  const RigReading reading = ReadCalibrationFiles({folder.path() / "rig.xml"});
  ASSERT_TRUE(reading.rig);
  EXPECT_TRUE(reading.problems.empty());
  EXPECT_EQ(reading.rig->width, 640);
  EXPECT_EQ(reading.rig->height, 480);
  EXPECT_DOUBLE_EQ(reading.rig->left.fx, 400.0);
  EXPECT_DOUBLE_EQ(reading.rig->left.fy, 410.0);
  EXPECT_DOUBLE_EQ(reading.rig->right.cy, 238.0);
  EXPECT_DOUBLE_EQ(reading.rig->left.distortion.at(0), -0.1);
  EXPECT_DOUBLE_EQ(reading.rig->baseline_m(), 0.12);
}

TEST(OpenCvXmlTest, RefusesWhatIsNoSuchFileWithItsLine) {
  const auto problem_of = [](const std::string& text) -> std::string {
    try {
      YamlFromOpenCvXml(text, "f.xml");
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem_of("<html></html>"),
              HasSubstr("f.xml:1: the outermost element must be opencv_storage"));
  EXPECT_THAT(problem_of("<opencv_storage>\n<a>1</b></opencv_storage>"),
              HasSubstr("f.xml:2: </a> must stand here"));
  EXPECT_THAT(problem_of("<opencv_storage><a>1</a><a>2</a></opencv_storage>"), HasSubstr("two elements a"));
  EXPECT_THAT(problem_of("<opencv_storage><a>1</a><_>2</_></opencv_storage>"),
              HasSubstr("must not be mixed"));
  for (std::size_t length = 0; length + 2 < std::string(kRigXml).size(); ++length)
    EXPECT_NE(problem_of(std::string(kRigXml).substr(0, length)), "") << "cut after " << length << " bytes";
  std::string deep = "<opencv_storage>";
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_THAT(problem_of(deep), HasSubstr("too deep"));
}

}  // namespace
}  // namespace terrace
