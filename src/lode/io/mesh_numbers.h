#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/io/image.h"

namespace lode::io {

/// How many bytes the arrays of a mesh file may still take, decoded: arrays may share their bytes
/// in the file, or say little about much.
struct MeshBudget {
  std::uint64_t n_bytes_left = 0;

  /// As much as deflate could make of a file, or the memory limit if that is less.
  [[nodiscard]] static MeshBudget of(std::uint64_t file_size, std::uint64_t memory_limit);

  /// Fails, naming `path`, when `n_bytes` more are beyond it.
  [[nodiscard]] Result<void> spend(const std::string& path, std::uint64_t n_bytes);
};

/// An array of a mesh file, as numbers of this machine.
struct MeshNumbers {
  ScalarType type = ScalarType::uint8;
  std::vector<std::byte> bytes;

  [[nodiscard]] std::size_t size() const { return bytes.size() / size_of(type); }
};

/// `n` numbers from the start of a store.
[[nodiscard]] Result<MeshNumbers> read_numbers(SampleStore& store, ScalarType type, ByteOrder order,
                                               std::uint64_t n);

[[nodiscard]] std::vector<double> as_doubles(const MeshNumbers& numbers);

inline constexpr std::int64_t kMaxWhole = std::numeric_limits<std::int64_t>::max();

/// What whole numbers have to be, and what messages call them.
struct WholeRange {
  const std::string& path;
  std::string_view name;
  std::int64_t low = 0;
  std::int64_t high = 0;
};

/// The numbers as T, which holds the range. Fails on a type that is no integer's, and on a number
/// beyond the range. For T of uint8, uint32, uint64 and int64.
template <typename T>
[[nodiscard]] Result<std::vector<T>> as_whole(const MeshNumbers& numbers, const WholeRange& range);

}  // namespace lode::io
