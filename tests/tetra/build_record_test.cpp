// What files say of how they were built.

#include "lode/models/tetra_mt/build_record.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "lode/core/label.h"
#include "tests/oracles/random.h"

namespace lode::tetra_mt {
namespace {

BuildRecord some_record() {
  BuildRecord record;
  record.order = CollapseOrder::quadric;
  record.keeps_extrema = true;
  record.boundary_tolerance = 0.25;
  record.volume_change = -1e-3;
  record.refusals = {{"shape", 12}, {"limit", std::numeric_limits<std::uint64_t>::max()}};
  record.reading = {{"ghost_cells", 0}, {"", 7}};
  record.notes = {{"cells to points", "größte: 3 at cells, 2 at points"}, {"", ""}};
  return record;
}

std::vector<std::byte> bytes_of(const BuildRecord& record) {
  store::ByteWriter out;
  write_record(record, out);
  return std::move(out).take();
}

Result<BuildRecord> read_back(const std::vector<std::byte>& bytes) {
  store::ByteReader in(bytes, "here");
  auto record = read_record(in, "here");
  if (record) LODE_CHECK(in.expect_end());
  return record;
}

TEST(build_record, is_read_as_it_was_written) {
  for (const BuildRecord& record : {BuildRecord(), some_record()}) {
    const auto found = read_back(bytes_of(record));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(*found, record);
  }
}

TEST(build_record, has_labels_whatever_it_is_given) {
  BuildRecord record = some_record();
  record.notes = {{"a\nb", std::string(3 * kMaxLabelBytes, 'x')}, {"\xff", "\x01"}};
  const auto found = read_back(bytes_of(record));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->notes[0].first, "a b");
  EXPECT_EQ(found->notes[0].second, to_label(record.notes[0].second));
  EXPECT_EQ(found->notes[1], BuildRecord::Note("?", " "));
}

TEST(build_record, is_refused_where_bytes_are_missing_or_lie) {
  const std::vector<std::byte> bytes = bytes_of(some_record());
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(read_back({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)})) << n;
  const auto with = [&](std::size_t at, int byte) {
    std::vector<std::byte> changed = bytes;
    changed[at] = static_cast<std::byte>(byte);
    return read_back(changed);
  };
  EXPECT_NE(with(0, 3).error().message.find("expected an order of 0 to 2"), std::string::npos);
  EXPECT_FALSE(with(1, 2));
  EXPECT_FALSE(with(9, 0xBF)) << "a tolerance below 0";
  // The number of refusals: more than a file may have is refused before any is read.
  EXPECT_NE(with(21, 0x7F).error().message.find("expected up to 256 records"), std::string::npos);
  oracles::Random random(3);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> changed = bytes;
    changed[random.below(changed.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (const auto found = read_back(changed)) {
      EXPECT_LE(found->notes.size(), changed.size());
    }
  }
}

TEST(build_record, names_the_rules_that_keep_vertices) {
  RefusalCounts counts;
  EXPECT_TRUE(named(counts).empty());
  counts.add(Refusal::limit);
  counts.add(Refusal::shape);
  counts.add(Refusal::shape);
  EXPECT_EQ(named(counts), (std::vector<BuildRecord::Count>{{"shape", 2}, {"limit", 1}}));
}

}  // namespace
}  // namespace lode::tetra_mt
