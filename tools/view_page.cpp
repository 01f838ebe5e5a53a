// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_page.h"

#include <openssl/evp.h>

#include "core/file_bytes.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

// viewer/index.html has it where a recording goes. The page's own script has it too, further up.
constexpr const char* kPlace = "<!--terrace-recording-->";

}  // namespace

std::string ReadViewPage(const fs::path& given) {
  if (!given.empty()) return ReadTextFile(given);
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path installed = folder / "../share/terrace/view.html";
  const fs::path built = folder / "../../viewer/index.html";  // build/release/tools, build/viewer
  for (const fs::path& page : {installed, built}) {
    if (fs::exists(page, error)) return ReadTextFile(page);
  }
  throw FileError("the page of the viewer is missing: " + installed.lexically_normal().string() +
                  " is not there; scripts/viewer builds it where there is npm (or name one by --page)");
}

std::string PageWithRecording(const std::string& page, std::span<const ViewBytes> records) {
  const std::size_t place = page.rfind(kPlace);
  if (place == std::string::npos) throw FileError("the page of the viewer has no place for a recording");
  std::string whole = page.substr(0, place);
  whole += R"(<script id="terrace-recording" type="text/plain">)";
  whole += Base64(ViewRecording(records));
  whole += "</script>";
  return whole + page.substr(place + std::string(kPlace).size());
}

std::string Base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // EVP ends it with a zero
  const int size =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

}  // namespace terrace
