// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/alignment.h"

#include <Eigen/SVD>

#include "core/check.h"

namespace terrace {
namespace {

struct MeanPositions {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();
};

MeanPositions MeanOf(const std::vector<PosePair>& pairs) {
  TERRACE_CHECK(!pairs.empty());
  MeanPositions mean;
  for (const PosePair& pair : pairs) {
    mean.result += pair.T_result_left.translation();
    mean.truth += pair.T_true_left.translation();
  }
  mean.result /= static_cast<double>(pairs.size());
  mean.truth /= static_cast<double>(pairs.size());
  return mean;
}

/// The rotation R for which trace(R^T m) is greatest.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d keep_right_handed = Eigen::Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) keep_right_handed(2, 2) = -1.0;
  return svd.matrixU() * keep_right_handed * svd.matrixV().transpose();
}

Eigen::Isometry3d WithEqualMeans(const Eigen::Matrix3d& R_true_result, const MeanPositions& mean) {
  Eigen::Isometry3d T_true_result = Eigen::Isometry3d::Identity();
  T_true_result.linear() = R_true_result;
  T_true_result.translation() = mean.truth - R_true_result * mean.result;
  return T_true_result;
}

}  // namespace

Eigen::Isometry3d AlignByPositions(const std::vector<PosePair>& pairs) {
  const MeanPositions mean = MeanOf(pairs);
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    cross += (pair.T_true_left.translation() - mean.truth) *
             (pair.T_result_left.translation() - mean.result).transpose();
  }
  return WithEqualMeans(NearestRotation(cross), mean);
}

Eigen::Isometry3d AlignByFirstPose(const std::vector<PosePair>& pairs) {
  TERRACE_CHECK(!pairs.empty());
  return pairs.front().T_true_left * pairs.front().T_result_left.inverse();
}

Eigen::Isometry3d AlignByOrientations(const std::vector<PosePair>& pairs) {
  const MeanPositions mean = MeanOf(pairs);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    sum += pair.T_true_left.linear() * pair.T_result_left.linear().transpose();
  }
  return WithEqualMeans(NearestRotation(sum), mean);
}

}  // namespace terrace
