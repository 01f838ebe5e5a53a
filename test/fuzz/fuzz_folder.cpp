// SPDX-License-Identifier: BSD-3-Clause
#include "test/fuzz/fuzz_folder.h"

#include <cstdlib>

#include <unistd.h>

#include "core/file_bytes.h"

namespace terrace::fuzz {

namespace fs = std::filesystem;

const fs::path& Folder() {
  static const fs::path folder = [] {
    const fs::path memory = "/dev/shm";
    const fs::path base = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    const fs::path made = base / ("terrace_fuzz_" + std::to_string(getpid()));
    fs::create_directories(made);
    std::atexit([] { fs::remove_all(Folder()); });
    return made;
  }();
  return folder;
}

fs::path Written(const std::string& name, Bytes bytes) {
  const fs::path path = Folder() / name;
  fs::create_directories(path.parent_path());
  WriteFileBytes(path, bytes);
  return path;
}

}  // namespace terrace::fuzz
