#pragma once

// What files of half edges and of midpoints say alike: docs/format.md, section 7.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/core/boundary_patch.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/store/bytes.h"
#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt {

/// Vertices or roots of the base in a block.
inline constexpr std::uint32_t kBasePart = 1U << 16;

/// Of metadata: regions, then patches, of a HierarchyHead or a ForestHead. What is read has no
/// names of regions where none has one, else one each.
struct HeadLabels {
  std::vector<std::int64_t> region_ids;
  std::vector<std::string> region_names;
  std::vector<BoundaryPatch> patches;
};
template <typename Head>
[[nodiscard]] HeadLabels labels_of(const Head& head) {
  return {head.region_ids, head.region_names, head.patches};
}
template <typename Head>
void take_labels(HeadLabels&& labels, Head& head) {
  head.region_ids = std::move(labels.region_ids);
  head.region_names = std::move(labels.region_names);
  head.patches = std::move(labels.patches);
}
void write_labels(const HeadLabels& labels, store::ByteWriter& out);
[[nodiscard]] Result<HeadLabels> read_labels(store::ByteReader& in, const std::string& path);
/// Of metadata: a box, which is finite, and how far the boundary may be off.
[[nodiscard]] Result<void> read_box(store::ByteReader& in, const std::string& path, Vec3d& lower,
                                    Vec3d& upper);
[[nodiscard]] Result<double> read_deviation(store::ByteReader& in, const std::string& path);
/// Likewise a field's largest world error of the base, none where it has none.
void write_world_error(const std::optional<double>& error, store::ByteWriter& out);
[[nodiscard]] Result<std::optional<double>> read_world_error(store::ByteReader& in,
                                                             const std::string& path,
                                                             const std::string& field);

/// Columns are compressed already.
[[nodiscard]] inline store::EncodedBlock as_block(const std::vector<std::byte>& bytes) {
  return store::encode_block_as(store::Codec::none, {.raw = bytes, .size = 1});
}
/// A writer of a file `to` that has all blocks of another one, as they are, and no metadata yet.
[[nodiscard]] Result<store::Writer> copy_blocks(const std::string& from, const std::string& to,
                                                std::string_view model, const Progress& progress);
[[nodiscard]] Result<std::vector<std::byte>> read_block(const store::Reader& reader,
                                                        const store::BlockKey& key);

/// Appends blocks of up to `size` of n things. `key_of(part)`, `encode(first, n)`: its bytes.
template <typename KeyOf, typename Encode>
[[nodiscard]] Result<void> append_parts(std::size_t n, std::size_t size, const KeyOf& key_of,
                                        const Encode& encode, store::Writer& writer) {
  for (std::size_t first = 0; first < n; first += size)
    LODE_CHECK(writer.append(key_of(static_cast<std::uint32_t>(first / size)),
                             as_block(encode(first, std::min(size, n - first)))));
  return {};
}
/// Reads them: `read(in, n)`.
template <typename KeyOf, typename Read>
[[nodiscard]] Result<void> read_parts(const store::Reader& reader, std::uint64_t n,
                                      const KeyOf& key_of, const Read& read) {
  for (std::uint64_t first = 0; first < n; first += kBasePart) {
    const store::BlockKey key = key_of(static_cast<std::uint32_t>(first / kBasePart));
    LODE_TRY(const auto bytes, read_block(reader, key));
    StreamReader in(bytes, reader.path() + ": " + store::describe(key));
    LODE_CHECK(read(in, static_cast<std::size_t>(std::min<std::uint64_t>(kBasePart, n - first))));
    LODE_CHECK(in.expect_end());
  }
  return {};
}

/// Fails where a base of so many bytes is more than the file could justify. Columns of zeros take
/// nothing: what is asked for is bounded by the file beforehand.
[[nodiscard]] Result<void> check_base_memory(const store::Reader& reader, std::uint64_t n_bytes);

}  // namespace lode::tetra_mt
