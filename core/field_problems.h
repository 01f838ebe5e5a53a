// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace terrace {

/// Collects what is wrong with settings, a sentence for each field: "paths = 3 must be 2, 4 or 8". All
/// settings complain by it, so that every complaint names field, value and rule in the same way.
class FieldProblems {
 public:
  /// @param must  how the sentence goes on behind "must", when the rule does not hold
  void Require(bool holds, const std::string& field, double value, const std::string& must);
  void Require(bool holds, const std::string& field, const std::string& value, const std::string& must);
  void Require(bool holds, const std::string& field, const std::vector<double>& value,
               const std::string& must);

  // The rules that come often. A value that is no number breaks each of them.
  void RequireAbove(const std::string& field, double value, double bound);
  void RequireAtLeast(const std::string& field, double value, double least);
  void RequireWithin(const std::string& field, double value, double least, double most);   ///< ends included
  void RequireInside(const std::string& field, double value, double bound, double limit);  ///< ends excluded
  void RequireUpTo(const std::string& field, double value, double bound, double most);     ///< upper end only

  std::vector<std::string> Take() { return std::move(problems_); }

 private:
  void Complain(const std::string& field, const std::string& value, const std::string& must);

  std::vector<std::string> problems_;
};

}  // namespace terrace
