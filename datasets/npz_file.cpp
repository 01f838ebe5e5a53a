// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/npz_file.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <memory>

#include <zip.h>

#include "core/json_value.h"

namespace terrace {
namespace {

// The format is that of numpy.lib.format: magic, version, length of a header that is a Python dictionary,
// the header, the elements.
constexpr std::size_t kMagicLength = 6;
constexpr std::size_t kMaxDimensions = 4;

/// The text after `'key':` in the header's dictionary.
std::string HeaderEntry(const std::string& header, const std::string& key, const std::string& where) {
  const std::size_t at = header.find("'" + key + "'");
  const std::size_t colon = at == std::string::npos ? at : header.find(':', at);
  if (colon == std::string::npos) throw FileError(where + ": the header has no " + key);
  const std::size_t begin = header.find_first_not_of(' ', colon + 1);
  if (begin == std::string::npos) throw FileError(where + ": the header has no " + key);
  return header.substr(begin);
}

std::size_t ElementBytes(const std::string& dtype, const std::string& where) {
  if (dtype == "|b1" || dtype == "|u1") return 1;
  if (dtype == "<f8") return 8;
  throw FileError(where + ": elements of type '" + dtype + "' are not known");
}

std::vector<std::size_t> ParseShape(const std::string& text, std::size_t max_elements,
                                    const std::string& where) {
  const std::size_t close = text.find(')');
  if (text.empty() || text[0] != '(' || close == std::string::npos) {
    throw FileError(where + ": the header has no shape");
  }
  std::vector<std::size_t> shape;
  std::size_t elements = 1;
  for (std::size_t i = 1; i < close;) {
    if (!std::isdigit(static_cast<unsigned char>(text[i]))) {
      ++i;
      continue;
    }
    std::size_t extent = 0;
    for (; i < close && std::isdigit(static_cast<unsigned char>(text[i])); ++i) {
      extent = extent * 10 + static_cast<std::size_t>(text[i] - '0');
      if (extent > max_elements) throw FileError(where + ": the shape does not fit the file");
    }
    shape.push_back(extent);
    if (shape.size() > kMaxDimensions) throw FileError(where + ": has too many dimensions");
    if (extent != 0 && elements > max_elements / extent) {
      throw FileError(where + ": the shape does not fit the file");
    }
    elements *= extent;
  }
  return shape;
}

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseEntry {
  void operator()(zip_file_t* entry) const { zip_fclose(entry); }
};

std::vector<std::uint8_t> ReadEntry(zip_t* archive, zip_uint64_t index, std::size_t size,
                                    const std::string& where) {
  const std::unique_ptr<zip_file_t, CloseEntry> entry(zip_fopen_index(archive, index, 0));
  if (!entry) throw FileError(where + ": cannot be opened: " + zip_strerror(archive));
  std::vector<std::uint8_t> bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const zip_int64_t got = zip_fread(entry.get(), bytes.data() + done, size - done);
    if (got <= 0) throw FileError(where + ": cannot be unpacked");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

/// A whole .npy file of version 1.0.
std::vector<std::uint8_t> NpyBytes(const NpyArray& array) {
  std::string header = "{'descr': '" + array.dtype + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t extent : array.shape) header += std::to_string(extent) + ", ";
  if (array.shape.size() > 1) header.erase(header.size() - 2);
  if (array.shape.size() == 1) header.erase(header.size() - 1);  // one element of a tuple keeps its comma
  header += "), }";
  // Magic, version and length take ten bytes; the elements begin at a multiple of 64.
  constexpr std::size_t kBefore = 10;
  constexpr std::size_t kAlignment = 64;
  while ((kBefore + header.size() + 1) % kAlignment != 0) header += ' ';
  header += '\n';
  std::vector<std::uint8_t> bytes{0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes.push_back(static_cast<std::uint8_t>(header.size() & 0xff));
  bytes.push_back(static_cast<std::uint8_t>(header.size() >> 8));
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.insert(bytes.end(), array.bytes.begin(), array.bytes.end());
  return bytes;
}

}  // namespace

std::size_t NpyArray::size() const {
  std::size_t elements = 1;
  for (std::size_t extent : shape) elements *= extent;
  return elements;
}

std::vector<double> NpyArray::Doubles() const {
  if (dtype != "<f8") throw FileError("an array of type '" + dtype + "' where '<f8' is wanted");
  std::vector<double> values(size());
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(double));
  return values;
}

std::vector<std::uint8_t> NpyArray::Bools() const {
  if (dtype != "|b1" && dtype != "|u1") {
    throw FileError("an array of type '" + dtype + "' where '|b1' is wanted");
  }
  std::vector<std::uint8_t> values(bytes);
  for (std::uint8_t& value : values) value = value != 0;
  return values;
}

NpyArray ParseNpy(const std::vector<std::uint8_t>& bytes, const std::string& where) {
  if (bytes.size() < kMagicLength + 4 || std::memcmp(bytes.data(), "\x93NUMPY", kMagicLength) != 0) {
    throw FileError(where + ": is not a .npy array");
  }
  const bool long_length = bytes[kMagicLength] >= 2;
  const std::size_t header_begin = kMagicLength + 2 + (long_length ? 4 : 2);
  if (bytes.size() < header_begin) throw FileError(where + ": is cut off");
  std::size_t header_length = 0;
  for (std::size_t i = header_begin; i-- > kMagicLength + 2;) header_length = header_length << 8 | bytes[i];
  if (header_length > bytes.size() - header_begin) throw FileError(where + ": is cut off");
  const auto* header_data = reinterpret_cast<const char*>(bytes.data()) + header_begin;
  const std::string header(header_data, header_length);
  const std::size_t data_begin = header_begin + header_length;
  const std::size_t data_length = bytes.size() - data_begin;

  NpyArray array;
  const std::string dtype = HeaderEntry(header, "descr", where);
  const std::size_t dtype_end = dtype.find('\'', 1);
  if (dtype[0] != '\'' || dtype_end == std::string::npos) throw FileError(where + ": has a compound type");
  array.dtype = dtype.substr(1, dtype_end - 1);
  if (HeaderEntry(header, "fortran_order", where).rfind("False", 0) != 0) {
    throw FileError(where + ": arrays in Fortran order are not known");
  }
  const std::size_t element_bytes = ElementBytes(array.dtype, where);
  array.shape = ParseShape(HeaderEntry(header, "shape", where), data_length / element_bytes, where);
  if (array.size() * element_bytes != data_length) {
    throw FileError(where + ": the shape does not fit the file");
  }
  array.bytes.assign(bytes.begin() + static_cast<std::ptrdiff_t>(data_begin), bytes.end());
  return array;
}

std::map<std::string, NpyArray> ReadNpzFile(const std::filesystem::path& path, std::size_t max_array_bytes) {
  int code = 0;
  const std::unique_ptr<zip_t, CloseArchive> archive(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (!archive) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw FileError(path.string() + ": cannot be read: " + reason);
  }
  std::map<std::string, NpyArray> arrays;
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const auto index = static_cast<zip_uint64_t>(i);
    zip_stat_t stat;
    if (zip_stat_index(archive.get(), index, 0, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE) ||
        !(stat.valid & ZIP_STAT_NAME)) {
      throw FileError(path.string() + ": has an entry without name or size");
    }
    std::string name = stat.name;
    const std::string where = path.string() + " " + name;
    if (stat.size > max_array_bytes) throw FileError(where + ": is larger than expected");
    if (name.size() > 4 && name.substr(name.size() - 4) == ".npy") name.resize(name.size() - 4);
    arrays[name] =
        ParseNpy(ReadEntry(archive.get(), index, static_cast<std::size_t>(stat.size), where), where);
  }
  return arrays;
}

void WriteNpzFile(const std::filesystem::path& path, const std::map<std::string, NpyArray>& arrays) {
  std::filesystem::remove(path);
  int error = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  if (archive == nullptr) throw FileError(path.string() + ": cannot be written");
  // libzip reads the buffers when it closes the archive.
  std::vector<std::vector<std::uint8_t>> files;
  files.reserve(arrays.size());
  bool good = true;
  for (const auto& [name, array] : arrays) {
    files.push_back(NpyBytes(array));
    zip_source_t* source = zip_source_buffer(archive, files.back().data(), files.back().size(), 0);
    const zip_int64_t index =
        source == nullptr ? -1 : zip_file_add(archive, (name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8);
    constexpr zip_uint16_t kMidnight = 0;
    constexpr zip_uint16_t kFirstOf1980 = 0x21;
    good = good && index >= 0 &&
           zip_file_set_dostime(archive, static_cast<zip_uint64_t>(index), kMidnight, kFirstOf1980, 0) == 0;
  }
  if (!good) {
    zip_discard(archive);
    throw FileError(path.string() + ": cannot be written");
  }
  if (zip_close(archive) != 0) {
    zip_discard(archive);
    throw FileError(path.string() + ": cannot be written");
  }
}

}  // namespace terrace
