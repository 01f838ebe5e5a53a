// SPDX-License-Identifier: BSD-3-Clause
#include "tools/folder_needs.h"

#include <system_error>

#include "datasets/image_file.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using Sentences = std::vector<std::string>;

bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Looks at a few files; a folder of images holds little else.
bool HoldsImages(const fs::path& folder) {
  constexpr int kEnough = 5;
  std::error_code error;
  int num_looked_at = 0;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!IsFile(entry->path())) continue;
    if (IsImageFile(entry->path())) return true;
    if (++num_looked_at == kEnough) break;
  }
  return false;
}

void NeedImages(const fs::path& folder, Sentences* missing) {
  if (!IsFolder(folder)) {
    missing->push_back(folder.string() + "/: missing, it must hold the images");
  } else if (!HoldsImages(folder)) {
    missing->push_back(folder.string() + "/: holds no PNG, JPEG or PNM images");
  }
}

Sentences EurocNeeds(const fs::path& mav) {
  Sentences missing;
  for (const char* camera : {"cam0", "cam1"}) {
    NeedImages(mav / camera / "data", &missing);
    if (!IsFile(mav / camera / "sensor.yaml")) {
      missing.push_back((mav / camera / "sensor.yaml").string() +
                        ": missing, the camera's calibration; terraced replay --calibration takes that of "
                        "any tool instead");
    }
  }
  return missing;
}

Sentences KittiNeeds(const fs::path& folder) {
  Sentences missing;
  const bool grey = IsFolder(folder / "image_0") || IsFolder(folder / "image_1");
  for (const char* images : {grey ? "image_0" : "image_2", grey ? "image_1" : "image_3"})
    NeedImages(folder / images, &missing);
  if (!IsFile(folder / "calib.txt")) {
    missing.push_back(
        (folder / "calib.txt").string() +
        ": missing, with the rows P0: and P1:; terraced replay --calibration takes that of any tool instead");
  }
  return missing;
}

}  // namespace

Sentences FolderNeeds(const fs::path& folder) {
  if (IsFolder(folder / "mav0")) return EurocNeeds(folder / "mav0");
  for (const char* images : {"image_0", "image_1", "image_2", "image_3"})
    if (IsFolder(folder / images)) return KittiNeeds(folder);
  if (IsFolder(folder / "cam0") || IsFolder(folder / "cam1"))
    return {folder.string() + ": cam0/ and cam1/ must lie in a folder mav0/; give the folder that holds it"};
  if (folder.filename() == "mav0") return {folder.string() + ": give the folder that holds mav0/"};
  if (HoldsImages(folder))
    return {
        folder.string() +
        ": holds images itself; those of the left and of the right camera must lie in image_0/ and image_1/, "
        "beside calib.txt"};
  return {folder.string() +
          ": an EuRoC folder holds mav0/cam0/ and mav0/cam1/, each with data/ and sensor.yaml; a KITTI "
          "folder image_0/ and image_1/ (or image_2/ and image_3/) with calib.txt"};
}

}  // namespace terrace
