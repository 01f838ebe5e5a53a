// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// A scene file cannot be used; what() has one line a problem: file, key, value and rule.
class SceneError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads a scene; README.md of this folder lists the keys. Throws SceneError with every problem at once.
Scene LoadScene(const std::filesystem::path& file);

/// The file of a scene: that of a shipped scene of this name, else the path of a YAML file. Throws
/// SceneError.
std::filesystem::path FindScene(const std::string& scene);

/// Names of the shipped scenes, ascending.
std::vector<std::string> ShippedScenes();

}  // namespace terrace::synthetic
