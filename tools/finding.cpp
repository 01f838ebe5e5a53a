// SPDX-License-Identifier: BSD-3-Clause
#include "tools/finding.h"

#include <algorithm>

#include "core/print.h"

namespace terrace {

const char* Name(Severity severity) {
  switch (severity) {
    case Severity::kGood:
      return "good";
    case Severity::kNote:
      return "note";
    case Severity::kTrouble:
      return "trouble";
  }
  return "?";
}

bool AnyTrouble(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.severity == Severity::kTrouble; });
}

std::string InWords(const Finding& finding) {
  std::string text =
      Printed("%-8s %-20s %s\n", Name(finding.severity), finding.code.c_str(), finding.text.c_str());
  if (!finding.remedy.empty()) text += Printed("%-8s %-20s -> %s\n", "", "", finding.remedy.c_str());
  return text;
}

}  // namespace terrace
