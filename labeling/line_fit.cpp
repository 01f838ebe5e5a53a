// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/line_fit.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Dense>

namespace terrace {

std::optional<LineFit> FitLine(const std::vector<LineValue>& values) {
  std::set<double> kinds;
  for (const LineValue& v : values)
    if (v.offset_sigma > 0.0) kinds.insert(v.offset_sigma);
  // Unknown: the value at zero, the slope, and the offset of each kind.
  const auto n = static_cast<Eigen::Index>(2 + kinds.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(n);
  const auto row_of = [&](const LineValue& v) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row[0] = 1.0;
    row[1] = v.x;
    if (v.offset_sigma > 0.0) row[2 + std::distance(kinds.begin(), kinds.find(v.offset_sigma))] = 1.0;
    return row;
  };
  for (const LineValue& v : values) {
    const Eigen::VectorXd row = row_of(v);
    const double weight = v.share / (v.sigma * v.sigma);
    information += weight * row * row.transpose();
    sums += weight * v.y * row;
  }
  Eigen::Index kind = 2;
  for (const double sigma : kinds) {
    information(kind, kind) += 1.0 / (sigma * sigma);
    ++kind;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(information);
  constexpr double kLeastInformation = 1e-6;
  if (values.empty() || solver.vectorD().minCoeff() < kLeastInformation) return std::nullopt;
  const Eigen::VectorXd solution = solver.solve(sums);

  double chi2 = 0.0, num = 0.0, weights = 0.0;
  for (const LineValue& v : values) {
    chi2 += v.share * std::pow((v.y - row_of(v).dot(solution)) / v.sigma, 2);
    num += v.share;
    weights += v.share / (v.sigma * v.sigma);
  }
  // The line has two numbers; a few values scatter by chance, so that two are counted which scatter as was
  // known beforehand.
  const double reduced_chi2 = (chi2 + 2.0) / std::max(1.0, num);
  const double slope_variance = solver.solve(Eigen::VectorXd::Unit(n, 1))[1];
  return LineFit{solution[0], solution[1], std::sqrt(std::max(1.0, reduced_chi2) * slope_variance),
                 std::sqrt(reduced_chi2 * num / weights)};
}

}  // namespace terrace
