// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

namespace terrace {

/// The evaluations (the text of evaluation.json) of the places of each family.
using FamilyEvaluations = std::map<std::string, std::vector<std::string>>;

/// Two rows a family, and two of all places together: the mean over the places, and the worst of them; of
/// staircases what holds of all of them together. A figure that no place has is a dash. Throws FileError when
/// a text is no evaluation.
std::string TableOfFamilies(const FamilyEvaluations& families);

}  // namespace terrace
