// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace terrace {

/// A promise between two functions was broken: a bug of ours, never of the input.
class CheckError : public std::logic_error {
  using std::logic_error::logic_error;
};

namespace internal {

template <typename... Values>
[[noreturn]] void FailCheck(const char* condition, const char* file, int line, const Values&... values) {
  std::ostringstream text;
  text << file << ':' << line << ": broken promise: " << condition;
  if constexpr (sizeof...(values) > 0) {
    text << " with";
    ((text << ' ' << values), ...);
  }
  throw CheckError(text.str());
}

}  // namespace internal
}  // namespace terrace

/// Throws CheckError when the condition does not hold; further arguments are printed with it.
#define TERRACE_CHECK(condition, ...)                                                            \
  do {                                                                                           \
    if (!(condition))                                                                            \
      ::terrace::internal::FailCheck(#condition, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__); \
  } while (false)
