// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace terrace {

/// One array of a .npy file, in C order.
struct NpyArray {
  std::string dtype;  ///< as numpy writes it: "|b1", "<f8", ...
  std::vector<std::size_t> shape;
  std::vector<std::uint8_t> bytes;

  std::size_t size() const;  ///< number of elements
  // The elements; FileError when the type is another.
  std::vector<double> Doubles() const;      ///< of "<f8"
  std::vector<std::uint8_t> Bools() const;  ///< of "|b1" or "|u1", as 0 and 1
};

/// The arrays of an .npz file by name (without ".npy"). Sizes come from the file and are checked before
/// anything is allocated: an array larger than `max_array_bytes` is refused. Throws FileError.
std::map<std::string, NpyArray> ReadNpzFile(const std::filesystem::path& path,
                                            std::size_t max_array_bytes = 64u << 20);

/// Writes arrays as numpy.savez_compressed does; the same arrays give the same bytes. Throws FileError.
void WriteNpzFile(const std::filesystem::path& path, const std::map<std::string, NpyArray>& arrays);

/// One .npy file that is already in memory; `where` names it in errors.
NpyArray ParseNpy(const std::vector<std::uint8_t>& bytes, const std::string& where);

}  // namespace terrace
