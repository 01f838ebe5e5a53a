// SPDX-License-Identifier: BSD-3-Clause
#include "core/lens.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "core/lens_models.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDegree = M_PI / 180.0;

/// Rays all around the axis up to an angle.
std::vector<Eigen::Vector3d> RaysUpTo(double angle_rad) {
  std::vector<Eigen::Vector3d> rays = {{0, 0, 1}};
  for (int ring = 1; ring <= 12; ++ring) {
    for (int k = 0; k < 16; ++k) {
      const double theta = angle_rad * ring / 12.0;
      const double phi = 2.0 * M_PI * (k + 0.3 * ring) / 16.0;
      rays.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    }
  }
  return rays;
}

RawCamera Camera(DistortionModel model, std::vector<double> distortion) {
  return {420.0, 431.0, 322.7, 237.1, model, std::move(distortion)};
}

void ExpectPixel(const Lens& lens, const Eigen::Vector3d& ray, double u, double v) {
  const auto pixel = lens.Project(2.7 * ray);  // of any length
  ASSERT_TRUE(pixel) << ray.transpose();
  EXPECT_NEAR(pixel->x(), u, 1e-8) << ray.transpose();
  EXPECT_NEAR(pixel->y(), v, 1e-8) << ray.transpose();
}

TEST(LensTest, AgreesWithOpenCvForEveryNumberOfCoefficients) {
  const std::vector<double> all = {-0.21, 0.06,  0.0011, -0.0007, 0.01,  0.12, -0.03,
                                   0.004, 0.002, -0.001, 0.0015,  -8e-4, 0.02, -0.013};
  for (const std::size_t n : {0u, 4u, 5u, 8u, 12u, 14u}) {
    const RawCamera camera =
        Camera(DistortionModel::kRadialTangential, {all.begin(), all.begin() + static_cast<long>(n)});
    const Lens lens(camera);
    const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    for (const Eigen::Vector3d& ray : RaysUpTo(42.0 * kDegree)) {
      std::vector<cv::Point2d> pixel;
      cv::projectPoints(std::vector<cv::Point3d>{{ray.x(), ray.y(), ray.z()}}, cv::Vec3d(), cv::Vec3d(), K,
                        camera.distortion, pixel);
      ExpectPixel(lens, ray, pixel[0].x, pixel[0].y);
    }
  }
}

TEST(LensTest, AgreesWithOpenCvsFisheye) {
  const RawCamera camera = Camera(DistortionModel::kEquidistant, {-0.02, -0.007, 0.002, -0.0012});
  const Lens lens(camera);
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  for (const Eigen::Vector3d& ray : RaysUpTo(85.0 * kDegree)) {
    std::vector<cv::Point2d> pixel;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{{ray.x(), ray.y(), ray.z()}}, pixel, cv::Vec3d(),
                               cv::Vec3d(), K, cv::Vec4d(camera.distortion.data()));
    ExpectPixel(lens, ray, pixel[0].x, pixel[0].y);
  }
}

TEST(LensTest, FollowsTheUnifiedSphereOfMei) {
  const double xi = 1.3, k1 = -0.11, k2 = 0.04, p1 = 0.0006, p2 = -0.0011;
  const RawCamera camera = Camera(DistortionModel::kOmni, {xi, k1, k2, p1, p2});
  const Lens lens(camera);
  for (const Eigen::Vector3d& ray : RaysUpTo(95.0 * kDegree)) {
    const double x = ray.x() / (ray.z() + xi), y = ray.y() / (ray.z() + xi);
    const double r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2;
    ExpectPixel(lens, ray, camera.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx,
                camera.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy);
  }
}

// The other models are given by how a pixel becomes a ray: each paper's closed form.

TEST(LensTest, TakesBackWhatTheDoubleSphereUnprojects) {
  const double xi = -0.17, alpha = 0.59;
  const RawCamera camera = Camera(DistortionModel::kDoubleSphere, {xi, alpha});
  const Lens lens(camera);
  for (double u = -200; u <= 800; u += 50) {
    for (double v = -200; v <= 700; v += 50) {
      const double mx = (u - camera.cx) / camera.fx, my = (v - camera.cy) / camera.fy;
      const double r2 = mx * mx + my * my;
      if (r2 > 1.0 / (2 * alpha - 1) * 0.98) continue;
      const double mz = (1 - alpha * alpha * r2) / (alpha * std::sqrt(1 - (2 * alpha - 1) * r2) + 1 - alpha);
      const double scale = (mz * xi + std::sqrt(mz * mz + (1 - xi * xi) * r2)) / (mz * mz + r2);
      const Eigen::Vector3d ray(scale * mx, scale * my, scale * mz - xi);
      EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
      ExpectPixel(lens, ray, u, v);
    }
  }
}

TEST(LensTest, TakesBackWhatTheExtendedUnifiedModelUnprojects) {
  const double alpha = 0.59, beta = 1.13;
  const RawCamera camera = Camera(DistortionModel::kExtendedUnified, {alpha, beta});
  const Lens lens(camera);
  for (double u = 0; u <= 640; u += 40) {
    for (double v = 0; v <= 480; v += 40) {
      const double mx = (u - camera.cx) / camera.fx, my = (v - camera.cy) / camera.fy;
      const double r2 = mx * mx + my * my;
      const double mz =
          (1 - beta * alpha * alpha * r2) / (alpha * std::sqrt(1 - (2 * alpha - 1) * beta * r2) + 1 - alpha);
      ExpectPixel(lens, Eigen::Vector3d(mx, my, mz).normalized(), u, v);
    }
  }
}

TEST(LensTest, TakesBackWhatTheFieldOfViewModelUnprojects) {
  const double w = 0.93;
  const RawCamera camera = Camera(DistortionModel::kFieldOfView, {w});
  const Lens lens(camera);
  for (double u = 0; u <= 640; u += 40) {
    for (double v = 0; v <= 480; v += 40) {
      const double mx = (u - camera.cx) / camera.fx, my = (v - camera.cy) / camera.fy;
      const double r = std::hypot(mx, my);
      const double scale = std::tan(r * w) / (2 * r * std::tan(w / 2));
      ExpectPixel(lens, Eigen::Vector3d(scale * mx, scale * my, 1).normalized(), u, v);
    }
  }
}

TEST(LensTest, TakesBackWhatScaramuzzasPolynomialUnprojects) {
  const double b1 = 0.0, b2 = -0.27, b3 = -0.037, b4 = 0.011, d = 0.001, e = -0.0007, c = 1.0004;
  RawCamera camera = Camera(DistortionModel::kPolynomial, {b1, b2, b3, b4, d, e, c});
  camera.fy = camera.fx;
  const Lens lens(camera);
  for (double mx = -1.1; mx <= 1.1; mx += 0.1) {
    for (double my = -1.1; my <= 1.1; my += 0.1) {
      const double rho = std::hypot(mx, my);
      const Eigen::Vector3d ray(mx, my, 1 + rho * (b1 + rho * (b2 + rho * (b3 + rho * b4))));
      ExpectPixel(lens, ray.normalized(), camera.fx * (mx + d * my) + camera.cx,
                  camera.fx * (e * mx + c * my) + camera.cy);
    }
  }
}

TEST(LensTest, UnprojectsWhatItProjects) {
  const RawCamera cameras[] = {
      Camera(DistortionModel::kRadialTangential, {}),
      Camera(DistortionModel::kRadialTangential, {-0.29, 0.08, 2e-4, -3e-4}),
      Camera(DistortionModel::kRadialTangential,
             {0.3, -0.1, 1e-3, 2e-3, 0.02, 0.5, -0.1, 0.03, 1e-3, 0, -1e-3, 0, 0.01, -0.02}),
      Camera(DistortionModel::kEquidistant, {-0.02, -0.007, 0.002, -0.0012}),
      Camera(DistortionModel::kOmni, {1.3, -0.11, 0.04, 6e-4, -1e-3}),
      Camera(DistortionModel::kDoubleSphere, {-0.17, 0.59}),
      Camera(DistortionModel::kExtendedUnified, {0.59, 1.13}),
      Camera(DistortionModel::kFieldOfView, {0.93}),
      Camera(DistortionModel::kPolynomial, {0.0, -0.27, -0.037, 0.011, 0.001, -7e-4, 1.0004})};
  for (const RawCamera& camera : cameras) {
    const Lens lens(camera);
    const bool wide = camera.model != DistortionModel::kRadialTangential;
    int num_seen = 0;
    for (const Eigen::Vector3d& ray : RaysUpTo((wide ? 75.0 : 40.0) * kDegree)) {
      const auto pixel = lens.Project(ray);
      ASSERT_TRUE(pixel) << Name(camera.model);
      const auto back = lens.Unproject(*pixel);
      ASSERT_TRUE(back) << Name(camera.model) << " " << ray.transpose();
      EXPECT_LT((*back - ray).norm(), 1e-9) << Name(camera.model) << " " << ray.transpose();
      ++num_seen;
    }
    EXPECT_GT(num_seen, 100);
  }
}

TEST(LensTest, SeesNothingBeyondWhereAModelTurnsBack) {
  // r (1 - 0.4 r^2) turns back at r = 0.913, 42.4 deg.
  const Lens lens(Camera(DistortionModel::kRadialTangential, {-0.4, 0, 0, 0}));
  EXPECT_NEAR(lens.max_angle_rad() / kDegree, 42.4, 0.3);
  EXPECT_TRUE(lens.Project({0.85, 0, 1}));
  EXPECT_FALSE(lens.Project({0.95, 0, 1}));
  EXPECT_FALSE(lens.Project({0, 0, -1}));
  EXPECT_FALSE(lens.Unproject({322.7 + 420 * 0.7, 237.1}));
  // A mirror-like sphere sees behind itself.
  const Lens wide(Camera(DistortionModel::kDoubleSphere, {-0.17, 0.59}));
  EXPECT_GT(wide.max_angle_rad() / kDegree, 95.0);
  EXPECT_TRUE(wide.Project({1, 0, -0.05}));
}

TEST(LensTest, KnowsTheFocalLengthOnTheAxis) {
  EXPECT_NEAR(Lens(Camera(DistortionModel::kOmni, {1.3, 0, 0, 0, 0})).focal_px().x(), 420 / 2.3, 1e-3);
  EXPECT_NEAR(Lens(Camera(DistortionModel::kDoubleSphere, {-0.17, 0.59})).focal_px().y(), 431 / 0.83, 1e-3);
  EXPECT_NEAR(Lens(Camera(DistortionModel::kFieldOfView, {0.93})).focal_px().x(),
              420 * 2 * std::tan(0.465) / 0.93, 1e-3);
}

TEST(LensTest, NamesEveryModelAndFindsItByName) {
  for (int i = 0; i <= static_cast<int>(DistortionModel::kPolynomial); ++i) {
    const auto model = static_cast<DistortionModel>(i);
    EXPECT_EQ(DistortionModelFromName(Name(model)), model);
  }
  EXPECT_FALSE(DistortionModelFromName("wobbly"));
}

TEST(LensProblemsTest, KnowsCoefficientsThatBelongToAnotherModel) {
  // What a rational model's first four look like when a driver calls them equidistant.
  EXPECT_THAT(LensProblems(Camera(DistortionModel::kEquidistant, {11.3, -118.0, 540.0, -820.0}), 640, 480),
              ElementsAre(HasSubstr("belong to another model than equidistant")));
  EXPECT_THAT(LensProblems(Camera(DistortionModel::kEquidistant, {-0.02, -0.007, 0.002, -0.0012}), 640, 480),
              IsEmpty());
}

TEST(LensProblemsTest, SaysWhatCannotBe) {
  EXPECT_THAT(
      LensProblems(Camera(DistortionModel::kRadialTangential, {0, 0, 0, 0, 0, 0}), 640, 480),
      ElementsAre(HasSubstr("6 distortion coefficients, the radial-tangential model takes 0, 4, 5, 8, "
                            "12 or 14")));
  EXPECT_THAT(LensProblems(Camera(DistortionModel::kDoubleSphere, {0.1, 1.4}), 640, 480),
              ElementsAre(HasSubstr("alpha = 1.4 must lie between 0 and 1")));
  EXPECT_THAT(LensProblems(Camera(DistortionModel::kRadialTangential, {-30, 0, 0, 0}), 640, 480),
              ElementsAre(HasSubstr("turns back at")));
}

}  // namespace
}  // namespace terrace
