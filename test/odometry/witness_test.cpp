// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/witness.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

constexpr double kHeardEvery_s = 0.066;
constexpr double kWitnessSigma = 0.004;  // rad and m
using Verdict = Witness::Verdict;

const Matrix6d kWitnessCovariance = Matrix6d::Identity() * kWitnessSigma * kWitnessSigma;

Vector6d ShiftBy(double m) {
  Vector6d error = Vector6d::Zero();
  error[3] = m;
  return error;
}

Vector6d TurnBy(double rad) {
  Vector6d error = Vector6d::Zero();
  error[1] = rad;
  return error;
}

Witness ProvenWitness() {
  Witness witness;
  for (int i = 0; i < 20; ++i) witness.Hear(Vector6d::Zero(), kWitnessCovariance, kHeardEvery_s);
  return witness;
}

TEST(WitnessTest, SaysNothingBeforeItHasAgreedForAWhile) {
  Witness witness;
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(witness.Hear(ShiftBy(1.0), kWitnessCovariance, kHeardEvery_s), Verdict::kAgrees);
}

TEST(WitnessTest, ContradictsWhatIsFarBeyondItsSigmas) {
  Witness witness = ProvenWitness();
  EXPECT_EQ(witness.Hear(ShiftBy(3 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s), Verdict::kAgrees);
  EXPECT_EQ(witness.Hear(ShiftBy(20 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s),
            Verdict::kContradicts);
  EXPECT_TRUE(witness.contradicts());
  EXPECT_FALSE(witness.turns_otherwise());
  EXPECT_DOUBLE_EQ(witness.apart()[3], 20 * kWitnessSigma);
  EXPECT_NEAR(witness.disagreed_s(), kHeardEvery_s, 1e-9);
}

TEST(WitnessTest, BelievesInNoAgreementThatFollowsOnAContradictionUntilItHasLasted) {
  Witness witness = ProvenWitness();
  witness.Hear(ShiftBy(20 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s);
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(witness.Hear(Vector6d::Zero(), kWitnessCovariance, kHeardEvery_s), Verdict::kAgreesAgain) << i;
  EXPECT_NEAR(witness.disagreed_s(), 5 * kHeardEvery_s, 1e-9);
  EXPECT_EQ(witness.Hear(Vector6d::Zero(), kWitnessCovariance, kHeardEvery_s), Verdict::kAgrees);
  EXPECT_EQ(witness.disagreed_s(), 0.0);
}

TEST(WitnessTest, FindsThatStepsLeadApartOfWhichEachIsPossible) {
  Witness witness = ProvenWitness();
  bool apart = false;
  for (int i = 0; i < 15; ++i)
    apart = apart || witness.Hear(ShiftBy(4 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s) ==
                         Verdict::kDriftsApart;
  EXPECT_TRUE(apart);
  EXPECT_GT(witness.apart()[3], 10 * kWitnessSigma);
}

TEST(WitnessTest, TellsATurnFromSomethingThatPassesBy) {
  Witness witness = ProvenWitness();
  witness.Hear(TurnBy(20 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s);
  EXPECT_TRUE(witness.turns_otherwise());
  witness.Hear(ShiftBy(40 * kWitnessSigma) + TurnBy(10 * kWitnessSigma), kWitnessCovariance, kHeardEvery_s);
  EXPECT_FALSE(witness.turns_otherwise());
}

TEST(WitnessTest, HasToProveItselfAnewAfterAReset) {
  Witness witness = ProvenWitness();
  witness.Reset();
  EXPECT_EQ(witness.Hear(ShiftBy(1.0), kWitnessCovariance, kHeardEvery_s), Verdict::kAgrees);
}

}  // namespace
}  // namespace terrace
