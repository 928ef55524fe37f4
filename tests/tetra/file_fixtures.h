#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {

inline tetra_mt::Hierarchy hierarchy_of(const TetraMesh& mesh, std::uint64_t base_cells) {
  Progress progress;
  const auto collapses = tetra_mt::collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = {}, .threads = {2}}, progress);
  EXPECT_TRUE(collapses);
  auto hierarchy = tetra_mt::make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  return std::move(*hierarchy);
}

/// Any.
inline tetra_mt::GradientsOf codes_of(const tetra_mt::Hierarchy& hierarchy) {
  return [n = hierarchy.positions.size()](std::size_t field) {
    std::vector<std::uint32_t> codes;
    for (std::uint32_t v = 0; v < n; ++v) {
      const std::uint32_t any = (v + static_cast<std::uint32_t>(field)) * 2654435761U;
      codes.push_back(any & ~(1U << 11 | 1U << 23));  // directions up to 2047
    }
    return codes;
  };
}

inline TetraMesh noise() { return oracles::noise_mesh(17, oracles::Cut::in_five, 5); }

/// Writes a file anew with some bytes of its blocks changed, and all checksums right.
inline void rewrite(const std::string& from, const std::string& to, oracles::Random& random) {
  const auto reader = store::Reader::open(from);
  ASSERT_TRUE(reader);
  std::vector<std::byte> metadata(reader->metadata().begin(), reader->metadata().end());
  if (random.below(4) == 0)
    metadata[random.below(metadata.size())] ^= static_cast<std::byte>(1 + random.below(255));
  auto writer = store::Writer::create(to, reader->model(), metadata);
  ASSERT_TRUE(writer);
  const std::size_t changed = random.below(reader->blocks().size());
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    auto bytes = reader->read_block(i);
    ASSERT_TRUE(bytes);
    if (i == changed || random.below(6) == 0)
      (*bytes)[random.below(bytes->size())] ^= static_cast<std::byte>(1 + random.below(255));
    ASSERT_TRUE(writer->append(reader->blocks()[i].key,
                               store::encode_block_as(store::Codec::none, {.raw = *bytes})));
  }
  ASSERT_TRUE(writer->finish());
}

}  // namespace lode::test
