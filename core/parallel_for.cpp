// SPDX-License-Identifier: BSD-3-Clause
#include "core/parallel_for.h"

#include <thread>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/cpu_account.h"

#ifdef TERRACE_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace terrace::parallel_for_detail {
namespace {

/// Runs pieces of one loop. Those that a thread of TBB takes over are booked on the account of the caller.
class Pieces {
 public:
  Pieces(void (*piece)(const void* body, std::size_t begin, std::size_t end), const void* body)
      : piece_(piece), body_(body) {}

  void Run(std::size_t begin, std::size_t end) const {
    if (account_ == nullptr || std::this_thread::get_id() == caller_) {
      piece_(body_, begin, end);
      return;
    }
    const CpuAccount::Scope scope(account_);
    const std::int64_t start_ns = ThreadCpuNs();
    piece_(body_, begin, end);
    account_->Book(ThreadCpuNs() - start_ns);
  }

 private:
  void (*const piece_)(const void* body, std::size_t begin, std::size_t end);
  const void* const body_;
  CpuAccount* const account_ = CpuAccount::Current();
  const std::thread::id caller_ = std::this_thread::get_id();
};

}  // namespace

// The distribution's TBB is not built for the thread sanitizer, which sees neither the start nor the end of a
// loop: in such a build this file is not instrumented either, and tells it of both, so that it judges the
// bodies alone.
void RunPieces(std::size_t count, void (*piece)(const void* body, std::size_t begin, std::size_t end),
               const void* body) {
  const tbb::blocked_range<std::size_t> whole(0, count);
  const Pieces pieces(piece, body);
#ifdef TERRACE_SANITIZE_THREAD
  char start = 0, end = 0;
  __tsan_release(&start);
  tbb::parallel_for(whole, [&](const auto& range) {
    __tsan_acquire(&start);
    pieces.Run(range.begin(), range.end());
    __tsan_release(&end);
  });
  __tsan_acquire(&end);
#else
  tbb::parallel_for(whole, [&](const auto& range) { pieces.Run(range.begin(), range.end()); });
#endif
}

}  // namespace terrace::parallel_for_detail
