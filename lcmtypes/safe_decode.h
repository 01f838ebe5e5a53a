// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

namespace terrace {

/// The message in `size` bytes at `data`, fingerprint first; none when they are not exactly one message of
/// this type. Safe for any bytes: the generated decoders trust counts and string lengths, so the structure is
/// checked before they run, and what is allocated stays below a small multiple of `size`.
///
/// Exists for every type in this folder; include the type's header (<terrace/pose_t.hpp>) beside this one.
template <typename Message>
std::optional<Message> SafeDecode(const void* data, std::size_t size);

}  // namespace terrace
