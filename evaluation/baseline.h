// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace terrace {

/// How much worse one figure may get before that counts.
struct Tolerance {
  bool lower_is_better = true;
  /// The larger of the two holds; with neither the figure is shown and never judged.
  double absolute = 0.0;
  double relative = 0.0;  ///< share of the stored figure
  bool judged() const { return absolute > 0.0 || relative > 0.0; }
};

/// One figure of an evaluation by its path in evaluation.json ("map.coverage"), in the order of the columns.
struct BaselineFigure {
  std::string path;
  Tolerance tolerance;
};

using Figures = std::map<std::string, double>;

/// The stored figures that every later change is held against.
struct Baseline {
  std::vector<BaselineFigure> figures;
  std::map<std::string, Figures> sequences;  ///< by name; a figure that could not be measured is absent
};

/// What is compared when nothing is stored yet.
std::vector<BaselineFigure> DefaultFigures();

/// The figures that evaluation.json holds, of those that are asked for. Throws FileError.
Figures FiguresOf(const std::string& evaluation_json, const std::string& where,
                  const std::vector<BaselineFigure>& figures);

/// Throws FileError.
Baseline ParseBaseline(const std::string& text, const std::string& where);
std::string ToJson(const Baseline& baseline);

struct BaselineComparison {
  std::string table;
  std::vector<std::string> worse;  ///< a sentence each
};

/// One row a sequence and one column a figure, with the difference to the stored one. Names in `failed` have
/// no figures, which is worse than any. Sequences that are not stored are shown, not judged; stored ones that
/// did not run are left out.
BaselineComparison Compare(const Baseline& baseline, const std::map<std::string, Figures>& measured,
                           const std::vector<std::string>& failed);

}  // namespace terrace
