// SPDX-License-Identifier: BSD-3-Clause
#include "results/text_lines.h"

#include <sstream>

#include "core/file_bytes.h"

namespace terrace {

void ForEachLine(const std::filesystem::path& path,
                 const std::function<void(const std::string& line, const std::string& place)>& use) {
  std::istringstream in(ReadTextFile(path));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    use(line, path.string() + ":" + std::to_string(number));
  }
}

}  // namespace terrace
