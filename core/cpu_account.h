// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>

namespace terrace {

/// CPU time that the calling thread has used so far.
std::int64_t ThreadCpuNs();

/// CPU time that other threads spend on behalf of one. While it is open on a thread, ParallelFor books here
/// what TBB's threads work for that thread.
class CpuAccount {
 public:
  void Book(std::int64_t cpu_ns) { helper_ns_ += cpu_ns; }
  std::int64_t helper_ns() const { return helper_ns_; }

  /// The one that is open on the calling thread; null: none.
  static CpuAccount* Current();

  /// Opens an account on the calling thread until the end of the scope.
  class Scope {
   public:
    explicit Scope(CpuAccount* account);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    CpuAccount* const before_;
  };

 private:
  std::atomic<std::int64_t> helper_ns_{0};
};

}  // namespace terrace
