#include "lode/io/border_spool.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/io/unit_source.h"
#include "tests/oracles/synthetic_volumes.h"

namespace lode::io {
namespace {

using test::UnitSource;

std::vector<IndexRange> parts_of(std::int32_t n, std::int32_t edge) {
  std::vector<IndexRange> parts;
  for (std::int32_t lower = 0; lower < n; lower += edge)
    parts.push_back({std::max(0, lower - 4), std::min(n, lower + edge + 5)});
  return parts;
}

std::vector<std::byte> read_box(VolumeSource& source, const IndexBox& box) {
  std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) *
                             size_of(source.info().type));
  EXPECT_TRUE(source.read(box, out));
  return out;
}

struct SpoolCase {
  Index3 dims;
  Index3 unit;
  ScalarType type = ScalarType::uint8;
  std::array<bool, 3> parted{true, true, true};

  friend void PrintTo(const SpoolCase& c, std::ostream* out) {
    *out << c.dims[0] << " x " << c.dims[1] << " x " << c.dims[2] << " in " << c.unit[0] << " x "
         << c.unit[1] << " x " << c.unit[2];
  }
};

class border_spool : public ::testing::TestWithParam<SpoolCase> {
 protected:
  static constexpr std::int32_t kEdge = 32;

  void SetUp() override {
    const Index3& dims = GetParam().dims;
    reads_.slice_axis = dims[2] > 1 ? 2 : 1;
    for (std::size_t i = 0; i < 3; ++i)
      reads_.parts[i] =
          GetParam().parted[i] ? parts_of(dims[i], kEdge) : std::vector<IndexRange>{{0, dims[i]}};
    auto made = BorderSpool::make(source_, reads_, testing::TempDir());
    ASSERT_TRUE(made) << made.error().message;
    spool_ = std::move(*made);
    ASSERT_NE(spool_, nullptr);
  }
  /// Slices up to `end`, a few at a time.
  void pass(std::int32_t end) {
    const auto axis = static_cast<std::size_t>(reads_.slice_axis);
    IndexBox slab{{}, GetParam().dims};
    for (std::int32_t begin = 0; begin < end; begin = slab.upper[axis]) {
      slab.lower[axis] = begin;
      slab.upper[axis] = std::min(end, begin + 7);
      EXPECT_TRUE(read_box(*spool_, slab) == read_box(*plain_, slab));
    }
  }
  [[nodiscard]] std::vector<IndexBox> parts() const {
    std::vector<IndexBox> boxes;
    for (const IndexRange& y : reads_.parts[1])
      for (const IndexRange& z : reads_.parts[2])
        for (const IndexRange& x : reads_.parts[0])
          boxes.push_back({{{x.lower, y.lower, z.lower}}, {{x.upper, y.upper, z.upper}}});
    return boxes;
  }
  [[nodiscard]] std::uint64_t n_moved() const {
    const IoCounts io = spool_->io();
    return io.n_file_bytes_read + io.n_spool_bytes_read + io.n_spool_bytes_written;
  }

  Volume volume_ = oracles::noise(GetParam().dims, {.type = GetParam().type});
  UnitSource source_{volume_, GetParam().unit};
  std::unique_ptr<VolumeSource> plain_ = make_memory_source(volume_);
  PartedReads reads_;
  std::unique_ptr<BorderSpool> spool_;
};

TEST_P(border_spool, gives_parts_their_samples_and_moves_fewer_bytes) {
  pass(GetParam().dims[static_cast<std::size_t>(reads_.slice_axis)]);
  (void)source_.take_counts();
  const std::uint64_t n_before = n_moved() - spool_->io().n_spool_bytes_written;
  UnitSource again(volume_, GetParam().unit);
  for (const IndexBox& part : parts()) {
    spool_->begin_part(part);
    const auto expected = read_box(*plain_, part);
    EXPECT_TRUE(read_box(*spool_, part) == expected);
    EXPECT_TRUE(read_box(again, part) == expected);
  }
  EXPECT_LT(n_moved() - n_before, again.io().n_file_bytes_read);
  const Index3& unit = GetParam().unit;
  if (kEdge % unit[0] != 0 || kEdge % unit[1] != 0 || kEdge % unit[2] != 0) return;
  for (const auto& [place, n] : source_.take_counts()) EXPECT_EQ(n, 1);  // no part cuts a unit
}

TEST_P(border_spool, gives_any_box_for_any_part_whatever_is_kept_yet) {
  const std::int32_t n = GetParam().dims[static_cast<std::size_t>(reads_.slice_axis)];
  for (const std::int32_t n_passed : {0, n / 2, n}) {
    SetUp();
    pass(n_passed);
    const std::vector<IndexBox> parts = this->parts();
    std::mt19937_64 random(7);
    for (int round = 0; round < 150; ++round) {
      spool_->begin_part(parts[random() % parts.size()]);
      IndexBox box;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto size = static_cast<std::uint64_t>(GetParam().dims[i]);
        box.lower[i] = static_cast<std::int32_t>(random() % size);
        const auto left = size - static_cast<std::uint64_t>(box.lower[i]);
        box.upper[i] = box.lower[i] + static_cast<std::int32_t>(random() % (left + 1));
      }
      ASSERT_TRUE(read_box(*spool_, box) == read_box(*plain_, box)) << round;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    cases, border_spool,
    ::testing::Values(
        SpoolCase{{{80, 70, 90}}, {{16, 16, 16}}},
        SpoolCase{{{80, 70, 90}}, {{32, 16, 32}}, ScalarType::float32},
        SpoolCase{{{70, 100, 50}}, {{70, 32, 50}}, ScalarType::int16, {false, true, false}},
        SpoolCase{{{70, 100, 50}}, {{21, 23, 19}}, ScalarType::uint16},
        SpoolCase{{{34, 66, 97}}, {{40, 100, 96}}},
        SpoolCase{{{150, 130, 1}}, {{32, 32, 1}}, ScalarType::uint16},
        SpoolCase{{{150, 130, 1}}, {{50, 45, 1}}, ScalarType::uint8, {true, false, false}},
        SpoolCase{{{150, 1, 130}}, {{50, 1, 45}}},
        SpoolCase{{{1, 150, 130}}, {{1, 32, 45}}, ScalarType::float64}));

TEST(border_spool_file, is_not_made_where_nothing_is_kept_and_names_its_directory_where_it_fails) {
  const Volume volume = oracles::noise({{100, 9, 9}}, {.type = ScalarType::uint8});
  const PartedReads reads{2, {parts_of(100, 32), {{0, 9}}, {{0, 9}}}};
  const auto plain = make_memory_source(volume);
  const auto none = BorderSpool::make(*plain, reads, "/nowhere");
  ASSERT_TRUE(none);
  EXPECT_EQ(*none, nullptr);
  UnitSource source(volume, {{32, 9, 9}});
  const auto failed = BorderSpool::make(source, reads, "/nowhere");
  ASSERT_FALSE(failed);
  EXPECT_TRUE(failed.error().message.starts_with("/nowhere: no spool file"));
}

}  // namespace
}  // namespace lode::io
