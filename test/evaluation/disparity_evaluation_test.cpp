// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/disparity_evaluation.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "evaluation/planar_shape.h"

namespace terrace {
namespace {

constexpr double kFloatExact = 1e-6;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

FloatImage Row(const std::vector<float>& values) {
  FloatImage image(static_cast<int>(values.size()), 1);
  image.data = values;
  return image;
}

DisparityTruth AllVisible(const FloatImage& disparity_px) {
  return {disparity_px, std::vector<PixelTruth>(disparity_px.data.size(), PixelTruth::kVisible)};
}

/// Looks along world +x at a wall 4 m away, before which a board stands 2 m away: what a renderer would give,
/// by intersecting rays.
class SmallView : public ::testing::Test {
 protected:
  SmallView() {
    camera_.width = 160;
    camera_.height = 120;
    camera_.fx = camera_.fy = 200;
    camera_.cx = 79.5;
    camera_.cy = 59.5;
    camera_.baseline_m = 0.1;
    // Columns: right, down and forward of the camera in the world.
    T_world_left_.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    T_world_left_.translation() = Eigen::Vector3d(0, 0, 1);
    AddBoard(1, 4.0, -3.0, 3.0, -3.0, 5.0, "wall");
    AddBoard(2, 2.0, -0.3, 0.25, 0.8, 1.3, "obstacle");
    FloatImage disparity_px(camera_.width, camera_.height);
    truth_.labels = {camera_.width, camera_.height, std::vector<std::uint16_t>(disparity_px.data.size())};
    for (const TruePolygon& polygon : scene_.polygons) {
      const Plane plane_left = Moved(T_world_left_.inverse(), polygon.plane_world);
      const PlanarShape shape(polygon.plane_world, polygon.outline_world, {});
      const DisparityPlane plane = DisparityPlaneOf(plane_left, camera_);
      for (int v = 0; v < camera_.height; ++v) {
        for (int u = 0; u < camera_.width; ++u) {
          const double d = plane.At(u, v);
          if (!shape.LiesOver(T_world_left_ * camera_.Triangulate(u, v, d))) continue;
          disparity_px.At(u, v) = static_cast<float>(d);
          truth_.labels.data[disparity_px.Index(u, v)] = static_cast<std::uint16_t>(polygon.id);
        }
      }
    }
    truth_.disparity = ByForwardWarping(disparity_px);
  }

  /// An upright board that faces the camera.
  void AddBoard(int id, double x, double y0, double y1, double z0, double z1, const char* label) {
    TruePolygon board;
    board.id = id;
    board.label = label;
    board.plane_world = {-Eigen::Vector3d::UnitX(), -x};
    board.outline_world = {{x, y0, z0}, {x, y0, z1}, {x, y1, z1}, {x, y1, z0}};
    scene_.polygons.push_back(board);
  }

  DisparityEvaluation Evaluate(const FloatImage& disparity_px) const {
    DisparityEvaluation evaluation;
    evaluation.errors.Add(disparity_px, truth_.disparity);
    evaluation.planes = FitPlanes(disparity_px, truth_, scene_, camera_, T_world_left_);
    evaluation.edges = FitEdges(disparity_px, truth_, scene_, camera_, T_world_left_);
    return evaluation;
  }

  StereoCamera camera_;
  Eigen::Isometry3d T_world_left_ = Eigen::Isometry3d::Identity();
  TrueScene scene_;
  RenderedTruth truth_;
};

TEST(DisparityErrorsTest, CountsBadMissingAndInventedPixels) {
  // True 10 px everywhere. Values off by 0, 0.6, 1.2, 2.5, 4; one missing. Then two hidden pixels, one of
  // them with a value, and one of unknown truth with a value, which counts nowhere.
  DisparityTruth truth = AllVisible(Row({10, 10, 10, 10, 10, 10, 10, 10, kNaN}));
  truth.pixels[6] = truth.pixels[7] = PixelTruth::kHidden;
  truth.pixels[8] = PixelTruth::kNotKnown;
  DisparityErrors errors;
  errors.Add(Row({10, 10.6F, 8.8F, 12.5F, 14, kNaN, 10, kNaN, 33}), truth);
  EXPECT_EQ(errors.num_visible(), 6);
  EXPECT_NEAR(errors.density_pct(), 100 * 5.0 / 6, kFloatExact);
  EXPECT_NEAR(errors.bad_valid_pct(0.5), 80, kFloatExact);
  EXPECT_NEAR(errors.bad_valid_pct(1.0), 60, kFloatExact);
  EXPECT_NEAR(errors.bad_valid_pct(2.0), 40, kFloatExact);
  EXPECT_NEAR(errors.bad_all_pct(2.0), 50, kFloatExact);  // the missing one is wrong
  EXPECT_NEAR(errors.d1_valid_pct(), 20, kFloatExact);    // 4 px is more than 3 and more than 5 %
  EXPECT_NEAR(errors.d1_all_pct(), 100 * 2.0 / 6, kFloatExact);
  EXPECT_NEAR(errors.average_px(), (0.6 + 1.2 + 2.5 + 4) / 5, 1e-5);
  EXPECT_NEAR(errors.rms_px(), std::sqrt((0.36 + 1.44 + 6.25 + 16) / 5), 1e-5);
  EXPECT_NEAR(errors.invented_pct(), 50, kFloatExact);
}

TEST(DisparityErrorsTest, ForgivesD1WithinFivePercent) {
  DisparityErrors errors;
  errors.Add(Row({104}), AllVisible(Row({100})));
  EXPECT_EQ(errors.d1_valid_pct(), 0.0);
}

TEST(DisparityErrorsTest, FindsTheLockOfRoundedDisparitiesAndTheBiasOfShiftedOnes) {
  std::vector<float> truth, rounded, shifted;
  for (int i = 0; i < 20000; ++i) {
    truth.push_back(10.0F + 20.0F * (static_cast<float>(i) + 0.5F) / 20000.0F);
    rounded.push_back(std::round(truth.back()));
    shifted.push_back(truth.back() + 0.1F);
  }
  DisparityErrors errors;
  errors.Add(Row(rounded), AllVisible(Row(truth)));
  // Worst in the bins beside one half: their mean fraction is 0.475 or 0.525, so 0.475 px of error.
  EXPECT_NEAR(errors.lock_px(), 0.475, 1e-3);
  EXPECT_NEAR(errors.bias_px(), 0.0, 1e-3);
  errors = {};
  errors.Add(Row(shifted), AllVisible(Row(truth)));
  EXPECT_NEAR(errors.lock_px(), 0.1, 1e-4);
  EXPECT_NEAR(errors.bias_px(), 0.1, 1e-4);
}

TEST(DisparityTruthTest, HidesByWarpingWhatANearerPointCoversOrLiesOutside) {
  // Background at 2 px; the foreground, 6 px at columns 8 and 9, falls on columns 2 and 3 of the right image
  // and covers what is at columns 4 and 5. Columns 0 and 1 fall outside.
  const DisparityTruth truth = ByForwardWarping(Row({2, 2, 2, 2, 2, 2, 2, 2, 6, 6, 2, kNaN}));
  using enum PixelTruth;
  EXPECT_EQ(truth.pixels,
            (std::vector<PixelTruth>{kHidden, kHidden, kVisible, kVisible, kHidden, kHidden, kVisible,
                                     kVisible, kVisible, kVisible, kVisible, kNotKnown}));
}

TEST(DisparityTruthTest, ComparesWithTheRightTruth) {
  const DisparityTruth truth = ByRightTruth(Row({2, 2, 2, 2, 2}), Row({2, 6, kNaN, 2, 2}));
  using enum PixelTruth;
  EXPECT_EQ(truth.pixels, (std::vector<PixelTruth>{kHidden, kHidden, kVisible, kHidden, kNotKnown}));
}

TEST(DisparityTruthTest, ReadsTheMaskOfMiddlebury) {
  const DisparityTruth truth = ByMask(Row({5, 5, 5, kNaN}), {4, 1, {255, 128, 0, 255}});
  using enum PixelTruth;
  EXPECT_EQ(truth.pixels, (std::vector<PixelTruth>{kVisible, kHidden, kNotKnown, kNotKnown}));
}

TEST(DisparityTruthTest, TurnsPlanesIntoDisparitiesAndBack) {
  StereoCamera camera{640, 480, 400, 410, 319.5, 239.5, 0.12};
  const Plane plane{Eigen::Vector3d(0.1, -0.9, -0.3).normalized(), -0.4};
  const DisparityPlane disparity = DisparityPlaneOf(plane, camera);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(100, 400), Eigen::Vector2d(500, 300)}) {
    const double d = disparity.At(pixel.x(), pixel.y());
    EXPECT_NEAR(plane.SignedDistance(camera.Triangulate(pixel.x(), pixel.y(), d)), 0.0, 1e-12);
  }
  const Plane back = PlaneOf(disparity, camera);
  EXPECT_NEAR(std::abs(back.normal.dot(plane.normal)), 1.0, 1e-12);
  EXPECT_NEAR(std::abs(back.offset_m), 0.4, 1e-12);
}

TEST_F(SmallView, GivesPerfectMarksToTheTruth) {
  const DisparityEvaluation evaluation = Evaluate(truth_.disparity.disparity_px);
  EXPECT_NEAR(evaluation.errors.density_pct(), 100, kFloatExact);
  EXPECT_NEAR(evaluation.errors.average_px(), 0, kFloatExact);
  // Truth has a value on hidden pixels too; a matcher must not.
  EXPECT_NEAR(evaluation.errors.invented_pct(), 100, kFloatExact);
  EXPECT_EQ(evaluation.planes.size(), 2u);
  EXPECT_NEAR(evaluation.Planes({}, 10).offset_px, 0, 1e-5);
  EXPECT_NEAR(evaluation.Planes({}, 10).angle_deg, 0, 1e-3);
  // The board is 0.55 m wide and 0.5 m high: 55 columns, 50 rows; two edges each.
  EXPECT_NEAR(static_cast<double>(evaluation.edges.size()), 2 * (55 + 50), 4);
  // Pixels are whole, the edge is not: at best up to half a pixel.
  for (const EdgeFit& edge : evaluation.edges) EXPECT_LE(edge.distance_px, 0.5 + kFloatExact);
}

TEST_F(SmallView, MeasuresAnOffsetOfATenthOfAPixel) {
  FloatImage disparity_px = truth_.disparity.disparity_px;
  for (float& d : disparity_px.data) d += 0.1F;
  const DisparityEvaluation evaluation = Evaluate(disparity_px);
  const PlaneFigures board = evaluation.Planes({"obstacle"}, 10);
  EXPECT_EQ(board.count, 1);
  EXPECT_NEAR(board.offset_px, 0.1, 1e-4);
  // f b = 20: the board is at 10 px, 20 / 10.1 = 1.98020 m instead of 2 m.
  EXPECT_NEAR(board.offset_mm, 19.802, 1e-2);
  EXPECT_NEAR(evaluation.Planes({}, 3.0).count, 1, 0);  // the wall is farther
  EXPECT_NEAR(evaluation.errors.bias_px(), 0.1, 1e-4);
}

TEST_F(SmallView, MeasuresForegroundThatIsThreePixelsTooFat) {
  FloatImage disparity_px = truth_.disparity.disparity_px;
  const FloatImage original = disparity_px;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      for (int du = -3; du <= 3; ++du) {
        if (u + du < 0 || u + du >= camera_.width) continue;
        disparity_px.At(u, v) = std::max(disparity_px.At(u, v), original.At(u + du, v));
      }
    }
  }
  std::vector<double> left_and_right;
  for (const EdgeFit& edge : Evaluate(disparity_px).edges) {
    if (edge.distance_px > 1.0) left_and_right.push_back(edge.distance_px);
  }
  EXPECT_NEAR(static_cast<double>(left_and_right.size()), 100, 2);  // the rows, at both sides
  for (double distance_px : left_and_right) EXPECT_NEAR(distance_px, 3.0, 0.5 + kFloatExact);
}

TEST_F(SmallView, ToleratesOutliersInAPlane) {
  FloatImage disparity_px = truth_.disparity.disparity_px;
  for (std::size_t i = 0; i < disparity_px.data.size(); i += 5) disparity_px.data[i] += 8;
  for (const PlaneFit& plane : Evaluate(disparity_px).planes) {
    EXPECT_NEAR(plane.offset_px, 0, 2e-3);
    EXPECT_NEAR(plane.angle_deg, 0, 0.05);
  }
}

TEST(DisparityFileTest, ReadsPfmOfBothByteOrdersAndRefusesACutOne) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "terrace_pair.pfm";
  const auto write = [&](const std::string& head, const std::string& data) {
    std::ofstream(path, std::ios::binary) << head << data;
  };
  // 1.5 is 0x3fc00000, infinity 0x7f800000. The lower row comes first.
  write("Pf\n1 2\n-1.0\n", std::string("\x00\x00\x80\x7f\x00\x00\xc0\x3f", 8));
  FloatImage image = ReadDisparityFile(path);
  EXPECT_EQ(image.At(0, 0), 1.5F);
  EXPECT_TRUE(std::isnan(image.At(0, 1)));
  write("Pf\n1 2\n1.0\n", std::string("\x7f\x80\x00\x00\x3f\xc0\x00\x00", 8));
  EXPECT_EQ(ReadDisparityFile(path).At(0, 0), 1.5F);
  write("Pf\n100 200\n-1.0\n", "too short");
  EXPECT_THROW(ReadDisparityFile(path), FileError);
  write("Pf\n100000 100000\n-1.0\n", "too large");
  EXPECT_THROW(ReadDisparityFile(path), FileError);
  std::filesystem::remove(path);
}

TEST(DisparityTruthTest, LoadsTheConventionsOfMiddlebury) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA does not name the folder with the recordings";
  const std::filesystem::path middlebury = std::filesystem::path(data) / "middlebury";
  const auto count = [](const DisparityTruth& truth, PixelTruth kind) {
    return std::count(truth.pixels.begin(), truth.pixels.end(), kind);
  };
  // The mask holds 293954 times 255, 27900 times 128 and 18213 times 0.
  const DisparityTruth piano =
      LoadPairTruth(middlebury / "v3_quarter" / "Piano" / "disp0GT.pfm", std::nullopt, std::nullopt);
  EXPECT_EQ(count(piano, PixelTruth::kVisible), 293954);
  EXPECT_EQ(count(piano, PixelTruth::kHidden), 27900);
  // By the right truth, by forward warping; both agree on where most of a picture lies.
  for (const char* name : {"teddy", "tsukuba"}) {
    const std::filesystem::path truth = middlebury / "2001_2003" / name / "disp2.png";
    const double scale = std::string(name) == "teddy" ? 4.0 : 16.0;
    const DisparityTruth pair = LoadPairTruth(truth, scale, std::nullopt);
    const auto known =
        static_cast<double>(count(pair, PixelTruth::kVisible) + count(pair, PixelTruth::kHidden));
    EXPECT_GT(static_cast<double>(count(pair, PixelTruth::kVisible)) / known, 0.8) << name;
    EXPECT_GT(count(pair, PixelTruth::kHidden), 1000) << name;
  }
  EXPECT_THROW(ReadDisparityFile(middlebury / "2001_2003" / "teddy" / "disp2.png"), FileError);
}

}  // namespace
}  // namespace terrace
