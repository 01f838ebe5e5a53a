// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/leg_follower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::HasSubstr;

constexpr double kLegWalkSpeed = 0.5;  // m/s
constexpr double kLegWalkFrame_s = 0.1;

/// Walks along x; the images see every step as it is.
class LegWalk {
 public:
  /// @param unit  what the legs say for a metre
  void Go(double unit = 1.0, double jump_m = 0.0) {
    std::vector<BodyPrior> priors;
    for (int k = 0; k < 5; ++k) {
      t_s_ += kLegWalkFrame_s / 5;
      said_m_ += unit * kLegWalkSpeed * kLegWalkFrame_s / 5;
      if (k == 2) said_m_ += jump_m;
      BodyPrior prior;
      prior.t = Timestamp{static_cast<std::int64_t>(t_s_ * 1e9)};
      prior.T_odom_body.translation().x() = said_m_;
      prior.covariance.diagonal().setConstant(1e-6 * t_s_);
      priors.push_back(prior);
    }
    legs.Read(priors);
    legs.Compare(Eigen::Isometry3d(Eigen::Translation3d(kLegWalkSpeed * kLegWalkFrame_s, 0, 0)));
    if (const auto warning = legs.TakeWarning()) told += *warning + "\n";
  }

  LegFollower legs{25.0};
  std::string told;

 private:
  double t_s_ = 0.0;
  double said_m_ = 0.0;
};

TEST(LegFollowerTest, TakesTheGrowthOfACovarianceForThatOfTheStep) {
  LegWalk walk;
  for (int i = 0; i < 50; ++i) walk.Go();
  ASSERT_TRUE(walk.legs.step());
  EXPECT_NEAR(walk.legs.step()->T_odom_body.translation().x(), kLegWalkSpeed * kLegWalkFrame_s, 1e-9);
  EXPECT_NEAR(walk.legs.step()->covariance(0, 0), 1e-6 * kLegWalkFrame_s, 1e-9);
  EXPECT_TRUE(walk.told.empty()) << walk.told;
}

TEST(LegFollowerTest, LeavesAJumpOutAndGoesOnAfterIt) {
  LegWalk walk;
  for (int i = 0; i < 5; ++i) walk.Go();
  walk.Go(1.0, 5.0);
  EXPECT_FALSE(walk.legs.step());
  EXPECT_THAT(walk.told, HasSubstr("jumps by 5.0 m"));
  walk.Go();
  ASSERT_TRUE(walk.legs.step());
  EXPECT_NEAR(walk.legs.step()->T_odom_body.translation().x(), kLegWalkSpeed * kLegWalkFrame_s, 1e-9);
}

TEST(LegFollowerTest, NamesMillimetresAndCentimetres) {
  LegWalk millimetres, centimetres;
  for (int i = 0; i < 12; ++i) millimetres.Go(1000.0), centimetres.Go(100.0);
  EXPECT_THAT(millimetres.told, HasSubstr("millimetres"));
  EXPECT_THAT(centimetres.told, HasSubstr("centimetres"));
  EXPECT_FALSE(millimetres.legs.step());
}

TEST(LegFollowerTest, BelievesRefusedLegsAgainOnceTheyAgree) {
  LegWalk walk;
  for (int i = 0; i < 20; ++i) walk.Go(2.0);
  EXPECT_THAT(walk.told, HasSubstr("times as far"));
  EXPECT_FALSE(walk.legs.step());
  for (int i = 0; i < 40; ++i) walk.Go();
  EXPECT_TRUE(walk.legs.step());
  EXPECT_THAT(walk.told, HasSubstr("agrees with the images again"));
}

}  // namespace
}  // namespace terrace
