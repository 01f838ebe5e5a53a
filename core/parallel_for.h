// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace terrace {

namespace parallel_for_detail {
void RunPieces(std::size_t count, void (*piece)(const void* body, std::size_t begin, std::size_t end),
               const void* body);
}

/// Calls body(begin, end) for pieces that together are [0, count), shared by TBB's threads. Returns when all
/// are done; which thread takes which piece is left to chance, so a piece must not depend on another. Target:
/// terrace::parallel_for.
template <typename Body>
void ParallelForPieces(std::size_t count, const Body& body) {
  parallel_for_detail::RunPieces(
      count,
      [](const void* erased, std::size_t begin, std::size_t end) {
        (*static_cast<const Body*>(erased))(begin, end);
      },
      &body);
}

/// The same with body(i) for every i of [0, count).
template <typename Body>
void ParallelFor(int count, const Body& body) {
  ParallelForPieces(static_cast<std::size_t>(count), [&body](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(static_cast<int>(i));
  });
}

}  // namespace terrace
