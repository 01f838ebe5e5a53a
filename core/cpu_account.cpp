// SPDX-License-Identifier: BSD-3-Clause
#include "core/cpu_account.h"

#include <ctime>
#include <utility>

namespace terrace {
namespace {

thread_local CpuAccount* open_account = nullptr;

}  // namespace

std::int64_t ThreadCpuNs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

CpuAccount* CpuAccount::Current() { return open_account; }

CpuAccount::Scope::Scope(CpuAccount* account) : before_(std::exchange(open_account, account)) {}
CpuAccount::Scope::~Scope() { open_account = before_; }

}  // namespace terrace
