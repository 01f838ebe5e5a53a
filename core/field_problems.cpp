// SPDX-License-Identifier: BSD-3-Clause
#include "core/field_problems.h"

#include "core/print.h"

namespace terrace {

void FieldProblems::Require(bool holds, const std::string& field, const std::string& value,
                            const std::string& must) {
  if (!holds) Complain(field, '"' + value + '"', must);
}

void FieldProblems::Require(bool holds, const std::string& field, double value, const std::string& must) {
  if (!holds) Complain(field, Printed("%.10g", value), must);
}

void FieldProblems::Require(bool holds, const std::string& field, const std::vector<double>& value,
                            const std::string& must) {
  if (holds) return;
  std::string list;
  for (const double number : value) Print(&list, list.empty() ? "%.10g" : ", %.10g", number);
  Complain(field, "[" + list + "]", must);
}

void FieldProblems::RequireAbove(const std::string& field, double value, double bound) {
  Require(value > bound, field, value, Printed("be above %g", bound));
}

void FieldProblems::RequireAtLeast(const std::string& field, double value, double least) {
  Require(value >= least, field, value, Printed("be at least %g", least));
}

void FieldProblems::RequireWithin(const std::string& field, double value, double least, double most) {
  Require(value >= least && value <= most, field, value, Printed("lie between %g and %g", least, most));
}

void FieldProblems::RequireInside(const std::string& field, double value, double bound, double limit) {
  Require(value > bound && value < limit, field, value, Printed("be above %g, below %g", bound, limit));
}

void FieldProblems::RequireUpTo(const std::string& field, double value, double bound, double most) {
  Require(value > bound && value <= most, field, value, Printed("be above %g, at most %g", bound, most));
}

void FieldProblems::Complain(const std::string& field, const std::string& value, const std::string& must) {
  problems_.push_back(field + " = " + value + " must " + must);
}

}  // namespace terrace
