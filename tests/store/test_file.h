#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/store/format.h"
#include "lode/store/grid_filter.h"
#include "lode/store/reader.h"

namespace lode::store {

/// A path of its own in the temporary directory, removed with the object.
class TestPath {
 public:
  explicit TestPath(const std::string& name);
  ~TestPath();
  TestPath(const TestPath&) = delete;
  TestPath& operator=(const TestPath&) = delete;

  [[nodiscard]] const std::string& str() const { return path_; }

 private:
  std::string path_;
};

struct TestBlock {
  BlockKey key;
  std::size_t element_size = 1;
  std::vector<std::byte> raw;
  std::optional<ElementGrid> grid{};
};

/// Blocks of all element sizes that between them use every codec, and an empty one.
[[nodiscard]] std::vector<TestBlock> small_blocks();

/// What the elements of pattern_bytes are.
enum class Pattern {
  constant,
  ramp,  ///< Descends by 3.
  random,
  wave,   ///< Smooth, with noise of 2 bits.
  noise,  ///< Random in the lowest byte alone.
};
/// A smooth field on a grid, with noise of one bit; negative where it is below 0.
[[nodiscard]] std::vector<std::byte> grid_bytes(const ElementGrid& grid, std::size_t element_size);

/// Likewise of floats or doubles, of which at most 16 differ.
[[nodiscard]] std::vector<std::byte> few_values(const ElementGrid& grid, std::size_t element_size);

/// n_bytes of elements; the last may be cut short.
[[nodiscard]] std::vector<std::byte> pattern_bytes(Pattern pattern, std::size_t n_bytes,
                                                   std::size_t element_size);

[[nodiscard]] std::vector<std::byte> to_bytes(const std::string& text);

/// Writes them with the model name "test model" and the metadata "some metadata".
void write_file(const std::string& path, std::span<const TestBlock> blocks);

[[nodiscard]] std::vector<std::byte> load_file(const std::string& path);
void save_file(const std::string& path, std::span<const std::byte> bytes);

/// The message of the first error that opening and checking the whole file gives; empty if none.
[[nodiscard]] std::string open_and_check(const std::string& path);

/// Puts `value` at `offset` of a file in memory and makes the header's checksum right again.
template <typename T>
void patch_header(std::vector<std::byte>& file, std::size_t offset, T value);
extern template void patch_header(std::vector<std::byte>&, std::size_t, std::uint32_t);
extern template void patch_header(std::vector<std::byte>&, std::size_t, std::uint64_t);

/// A file in memory of these stored blocks under a directory of the caller's making, with right
/// sizes and checksums in the header.
[[nodiscard]] std::vector<std::byte> forge_file(std::span<const std::byte> blocks,
                                                std::span<const std::byte> directory);

}  // namespace lode::store
