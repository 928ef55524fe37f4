#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::ramp;
using test::samples_of;
using test::TempDir;

ReadOptions raw_options(const RawLayout& layout) {
  ReadOptions options;
  options.raw = layout;
  return options;
}

template <typename T>
class raw_reader_types : public testing::Test {};

using AllTypes =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t,
                   std::int32_t, std::uint64_t, std::int64_t, float, double>;
TYPED_TEST_SUITE(raw_reader_types, AllTypes);

TYPED_TEST(raw_reader_types, reads_both_byte_orders_plain_and_gzipped) {
  const TempDir dir;
  const auto samples = ramp<TypeParam>(5 * 4 * 3);
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    const auto options =
        raw_options({.dims = {{5, 4, 3}}, .type = scalar_type_of<TypeParam>, .byte_order = order});
    const std::string bytes = bytes_of(samples, order);
    EXPECT_EQ(samples_of<TypeParam>(dir.write("a.raw", bytes), options), samples);
    EXPECT_EQ(samples_of<TypeParam>(dir.write("a.raw.gz", test::gzipped(bytes)), options), samples);
  }
}

TYPED_TEST(raw_reader_types, reads_any_box_as_the_whole_has_it) {
  const TempDir dir;
  const auto samples = ramp<TypeParam>(5 * 4 * 3);
  const auto options = raw_options(
      {.dims = {{5, 4, 3}}, .type = scalar_type_of<TypeParam>, .byte_order = ByteOrder::big});
  const auto source = open_volume(dir.write("a.raw", bytes_of(samples, ByteOrder::big)), options);
  ASSERT_TRUE(source) << source.error().message;
  const Volume whole = make_volume<TypeParam>((*source)->info().grid, samples);
  const auto expected = make_memory_source(whole);
  const IndexBox boxes[] = {{{{0, 0, 0}}, {{5, 4, 1}}}, {{{0, 0, 1}}, {{5, 4, 3}}},
                            {{{1, 1, 1}}, {{4, 3, 3}}}, {{{4, 3, 2}}, {{5, 4, 3}}},
                            {{{0, 1, 0}}, {{5, 3, 3}}}, {{{2, 2, 2}}, {{2, 2, 2}}}};
  for (const IndexBox& box : boxes) {
    const auto n = static_cast<std::size_t>(box.n_samples()) * sizeof(TypeParam);
    std::vector<std::byte> ours(n);
    std::vector<std::byte> theirs(n);
    ASSERT_TRUE((*source)->read(box, ours));
    ASSERT_TRUE(expected->read(box, theirs));
    EXPECT_EQ(ours, theirs);
  }
}

TEST(raw_reader, keeps_spacing_and_origin_and_mirrors_a_negative_spacing) {
  const TempDir dir;
  const auto path = dir.write("a.dat", "abcdef");
  const auto info = test::info_of(
      path, raw_options({.dims = {{3, 2, 1}}, .spacing = {{0.5, -2, 3}}, .origin = {{7, 8, 9}}}));
  EXPECT_EQ(info.grid.spacing, (Vec3d{{0.5, 2, 3}}));
  EXPECT_EQ(info.grid.origin, (Vec3d{{7, 8, 9}}));
  EXPECT_EQ(info.grid.direction.column(1), (Vec3d{{0, -1, 0}}));
  EXPECT_EQ(info.grid.frame, Frame::unknown);
}

TEST(raw_reader, refuses_a_size_that_does_not_fit) {
  const TempDir dir;
  const auto path = dir.write("a.raw", "abcdef");
  expect_failure(path, {"expected 8 bytes", "has 6"}, raw_options({.dims = {{2, 2, 2}}}));
  expect_failure(path, {"expected 4 bytes", "has 6"}, raw_options({.dims = {{2, 2, 1}}}));
  expect_failure(path, {"between 1 and", "got 0"}, raw_options({.dims = {{6, 0, 1}}}));
  expect_failure(path, {"axis y", "got -1"}, raw_options({.dims = {{6, -1, -1}}}));
  const std::int32_t most = 2147483646;
  expect_failure(path, {"2^63"}, raw_options({.dims = {{most, most, most}}}));
}

TEST(raw_reader, refuses_gzip_data_that_are_short_long_or_too_small_for_the_promise) {
  const TempDir dir;
  const auto path = dir.write("a.raw.gz", test::gzipped(std::string(100, 'x')));
  expect_failure(path, {"expected 108 bytes", "hold 100"}, raw_options({.dims = {{108, 1, 1}}}));
  expect_failure(path, {"expected 27 bytes", "more"}, raw_options({.dims = {{3, 3, 3}}}));
  expect_failure(path, {"promises"}, raw_options({.dims = {{30000, 30000, 1000}}}));
  const auto bytes = test::gzipped(bytes_of(ramp<std::uint32_t>(500)));
  expect_failure(dir.write("b.raw.gz", bytes.substr(0, bytes.size() / 2)), {"end too early"},
                 raw_options({.dims = {{500, 1, 1}}, .type = ScalarType::uint32}));
  expect_failure(dir.write("c.raw.gz", "not gzip at all"), {"damaged"},
                 raw_options({.dims = {{5, 1, 1}}}));
}

TEST(raw_reader, reads_gzip_files_of_several_members) {
  const TempDir dir;
  const auto path = dir.write("a.raw.gz", test::gzipped("abc") + test::gzipped("defgh"));
  const auto samples = samples_of<std::uint8_t>(path, raw_options({.dims = {{8, 1, 1}}}));
  EXPECT_EQ(std::string(samples.begin(), samples.end()), "abcdefgh");
}

TEST(raw_reader, refuses_zero_and_infinite_spacings) {
  const TempDir dir;
  const auto path = dir.write("a.raw", "abcdefgh");
  RawLayout layout{.dims = {{2, 2, 2}}, .spacing = {{1, 0, 1}}};
  expect_failure(path, {"spacing along axis y"}, raw_options(layout));
  layout.spacing[1] = std::numeric_limits<double>::infinity();
  expect_failure(path, {"axis y"}, raw_options(layout));
  layout.spacing[1] = 1;
  layout.origin[0] = std::numeric_limits<double>::quiet_NaN();
  expect_failure(path, {"origin"}, raw_options(layout));
}

}  // namespace
}  // namespace lode::io
