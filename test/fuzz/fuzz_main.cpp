// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer calls this with what it makes up. The first byte chooses the reader, so that one program covers
// them all; TERRACE_FUZZ=NAME gives every input to one.
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "test/fuzz/fuzz_targets.h"

namespace {

using terrace::fuzz::Target;

std::vector<Target> AllTargets() {
  std::vector<Target> all = terrace::fuzz::FileTargets();
  for (const std::vector<Target>& more : {terrace::fuzz::SettingTargets(), terrace::fuzz::MessageTargets()})
    all.insert(all.end(), more.begin(), more.end());
  const char* only = std::getenv("TERRACE_FUZZ");
  if (!only) return all;
  for (const Target& target : all)
    if (std::strcmp(target.name, only) == 0) return {target};
  std::fprintf(stderr, "TERRACE_FUZZ=%s is none of:", only);
  for (const Target& target : all) std::fprintf(stderr, " %s", target.name);
  std::fputc('\n', stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<Target> targets = AllTargets();
  if (size == 0) return 0;
  targets[data[0] % targets.size()].read({data + 1, size - 1});
  return 0;
}
