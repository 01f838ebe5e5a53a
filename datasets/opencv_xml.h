// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace terrace {

/// The same content as YAML: what OpenCV's FileStorage writes into .xml. Elements are keys, elements named
/// "_" items of a list, several words of a text a list, matrices {rows, cols, dt, data}. `where` stands for
/// the file in messages. Throws FileError.
std::string YamlFromOpenCvXml(const std::string& text, const std::string& where);

}  // namespace terrace
