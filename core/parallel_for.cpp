// SPDX-License-Identifier: BSD-3-Clause
#include "core/parallel_for.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#ifdef TERRACE_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace terrace::parallel_for_detail {

// The distribution's TBB is not built for the thread sanitizer, which sees neither the start nor the end of a
// loop: in such a build this file is not instrumented either, and tells it of both, so that it judges the
// bodies alone.
void RunPieces(std::size_t count, void (*piece)(const void* body, std::size_t begin, std::size_t end),
               const void* body) {
  const tbb::blocked_range<std::size_t> whole(0, count);
#ifdef TERRACE_SANITIZE_THREAD
  char start = 0, end = 0;
  __tsan_release(&start);
  tbb::parallel_for(whole, [&](const auto& range) {
    __tsan_acquire(&start);
    piece(body, range.begin(), range.end());
    __tsan_release(&end);
  });
  __tsan_acquire(&end);
#else
  tbb::parallel_for(whole, [&](const auto& range) { piece(body, range.begin(), range.end()); });
#endif
}

}  // namespace terrace::parallel_for_detail
