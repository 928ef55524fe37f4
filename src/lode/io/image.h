#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/core/regular_grid.h"
#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/io/input_file.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// The samples of one field, as bytes that can be read at any offset.
class SampleStore {
 public:
  virtual ~SampleStore() = default;
  [[nodiscard]] virtual Result<void> read(std::uint64_t offset, std::span<std::byte> out) = 0;
};

[[nodiscard]] std::unique_ptr<SampleStore> make_memory_store(std::vector<std::byte> bytes);
/// Reads from the file, `offset` bytes on. Fails when the file lacks any of the `n_bytes`.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> make_file_store(InputFilePtr file,
                                                                   std::uint64_t offset,
                                                                   std::uint64_t n_bytes);

/// How the numbers of one field are stored. Strides count numbers, not bytes.
struct SampleLayout {
  ScalarType type = ScalarType::uint8;
  ByteOrder byte_order = ByteOrder::little;
  std::int64_t n_components = 1;
  std::int64_t n_times = 1;
  std::array<std::int64_t, 3> strides{};  ///< Of x, y, z.
  std::int64_t component_stride = 1;
  std::int64_t time_stride = 0;
  std::uint64_t n_bytes = 0;  ///< Of all components and times; checked against overflow.
};

/// One array of a file.
struct ImageField {
  std::string name;
  SampleLayout layout;
  double slope = 1;  ///< value = slope · stored + intercept
  double intercept = 0;
  std::string value_unit{};  ///< Of these values; empty: the file says none.
  /// Finds or decodes the samples; all sizes are checked before anything large is allocated.
  std::function<Result<std::unique_ptr<SampleStore>>()> load;
};

/// What a parsed header says; at least one field.
struct Image {
  std::string path;
  std::string format;
  std::string frame_note;
  RegularGrid grid;
  std::vector<ImageField> fields;
  IoTallyPtr tally;           ///< Of its files.
  std::string length_unit{};  ///< Empty: the file says none, or several.
};

/// x fastest after the components of a sample, then y, z, time. Fails when a count is below 1 or
/// too large, or the whole does not fit in 63 bits.
[[nodiscard]] Result<SampleLayout> interleaved_layout(const std::string& path, const Index3& dims,
                                                      ScalarType type, std::int64_t n_components,
                                                      std::int64_t n_times);

/// Checks counts >= 1 and returns the product of all with `size`; fails on overflow.
[[nodiscard]] Result<std::uint64_t> checked_n_bytes(const std::string& path,
                                                    std::span<const std::int64_t> counts,
                                                    std::size_t size);

/// The three counts as dims, each within [1, 2^31 - 2].
[[nodiscard]] Result<Index3> checked_dims(const std::string& path,
                                          std::span<const std::int64_t> counts);

/// Turns samples in the given byte order into this machine's, in place.
void to_native(std::span<std::byte> bytes, ScalarType type, ByteOrder order);

/// `n` numbers from the start of a store.
[[nodiscard]] Result<std::vector<double>> read_doubles(SampleStore& store, ScalarType type,
                                                       ByteOrder order, std::size_t n);

}  // namespace lode::io
