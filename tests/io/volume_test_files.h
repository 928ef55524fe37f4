#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "lode/core/volume.h"
#include "lode/io/volume_reader.h"

namespace lode::io::test {

/// A directory of its own for a test, removed at the end.
class TempDir {
 public:
  TempDir();
  ~TempDir();
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;

  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& bytes) const;
  [[nodiscard]] std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The numbers' bytes, in the given order.
template <typename T>
std::string bytes_of(const std::vector<T>& numbers, ByteOrder order = ByteOrder::little) {
  std::string bytes(numbers.size() * sizeof(T), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  if (order == ByteOrder::big)
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(T))
      std::reverse(bytes.data() + i, bytes.data() + i + sizeof(T));
  return bytes;
}

/// n different numbers, negative ones among them where the type has any, spread over its bytes.
template <typename T>
std::vector<T> ramp(std::size_t n) {
  std::vector<T> numbers(n);
  for (std::size_t i = 0; i < n; ++i) {
    if constexpr (std::is_floating_point_v<T>)
      numbers[i] = static_cast<T>(i) * T(1.25) - T(7.5);
    else
      numbers[i] = static_cast<T>(static_cast<std::uint64_t>(i) * 0x0101010101010101ULL - 5);
  }
  return numbers;
}

std::string gzipped(const std::string& bytes);
std::string zlibbed(const std::string& bytes);
std::string base64(const std::string& bytes);

/// Opens a volume and reads all of it.
Result<Volume> read_volume(const std::string& path, const ReadOptions& options = {});

/// The samples of a file that must be readable and of type T.
template <typename T>
std::vector<T> samples_of(const std::string& path, const ReadOptions& options = {}) {
  const auto volume = read_volume(path, options);
  if (!volume) {
    ADD_FAILURE() << volume.error().message;
    return {};
  }
  EXPECT_EQ(volume->info.type, scalar_type_of<T>);
  if (volume->info.type != scalar_type_of<T>) return {};
  const auto samples = volume->template as<T>();
  return {samples.begin(), samples.end()};
}

/// The info of a file that must be readable.
VolumeInfo info_of(const std::string& path, const ReadOptions& options = {});

/// Expects an error whose message names the file and contains all `parts`.
void expect_failure(const std::string& path, const std::vector<std::string>& parts,
                    const ReadOptions& options = {});

/// A NIfTI-1 header of 352 bytes, to be changed field by field.
class NiftiBytes {
 public:
  /// dims: dim[1], dim[2], ...; vox_offset 352, magic n+1, pixdim 1.
  NiftiBytes(const std::vector<std::int16_t>& dims, std::int16_t datatype,
             ByteOrder order = ByteOrder::little);

  template <typename T>
  NiftiBytes& set(std::size_t offset, T value) {
    bytes_.replace(offset, sizeof(T), bytes_of<T>({value}, order_));
    return *this;
  }
  NiftiBytes& set_text(std::size_t offset, const std::string& text) {
    bytes_.replace(offset, text.size(), text);
    return *this;
  }
  /// Diagonal steps and an origin, code 1.
  NiftiBytes& set_sform(const std::vector<float>& rows);
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  ByteOrder order_;
};

/// A few random changes: bits, bytes, cuts, repeats, and hostile numbers in place of digits.
std::string mutated(std::string bytes, std::mt19937_64& random);

/// The directory of the shared real data: LODE_DATA, else ../shared/data beside the sources.
std::filesystem::path data_directory();

}  // namespace lode::io::test
