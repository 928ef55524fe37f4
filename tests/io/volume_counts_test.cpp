#include "lode/io/image.h"
#include "lode/io/image_source.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::ramp;
using test::TempDir;

/// A raw volume of 40 x 30 x 20 samples of 16 bits, and how to read it.
struct RawFile {
  TempDir dir;
  std::string path =
      dir.write("a.raw", test::bytes_of(ramp<std::int16_t>(std::size_t{40} * 30 * 20)));
  ReadOptions options;

  RawFile() { options.raw = RawLayout{.dims = {{40, 30, 20}}, .type = ScalarType::int16}; }
};

std::uint64_t file_bytes_of(VolumeSource& source, const IndexBox& box) {
  const std::uint64_t before = source.io().n_file_bytes_read;
  std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) *
                             size_of(source.info().type));
  EXPECT_TRUE(source.read(box, out));
  return source.io().n_file_bytes_read - before;
}

TEST(volume_counts, a_plain_file_counts_the_bytes_of_each_box) {
  const RawFile file;
  const auto source = open_volume(file.path, file.options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->io(), IoCounts{});
  EXPECT_EQ(file_bytes_of(**source, {{{0, 0, 0}}, {{40, 30, 20}}}), 48000U);
  EXPECT_EQ(file_bytes_of(**source, {{{0, 3, 5}}, {{40, 13, 7}}}), 40U * 10 * 2 * 2);
  EXPECT_EQ(file_bytes_of(**source, {{{1, 1, 1}}, {{3, 3, 3}}}), 2U * 2 * 2 * 2);
  EXPECT_EQ((*source)->io().n_spool_bytes_written, 0U);
  EXPECT_EQ((*source)->io().n_spool_bytes_read, 0U);
}

/// A store that notes how often and how much it is asked.
class WatchedStore final : public SampleStore {
 public:
  explicit WatchedStore(std::vector<std::uint64_t>& reads) : reads_(reads) {}

  Result<void> read(std::uint64_t, std::span<std::byte> out) override {
    reads_.push_back(out.size());
    return {};
  }

 private:
  std::vector<std::uint64_t>& reads_;
};

/// The sizes of the reads that a box of a volume of 40 x 30 x 20 samples takes.
std::vector<std::uint64_t> reads_of(const IndexBox& box, std::int64_t n_components, double slope) {
  std::vector<std::uint64_t> reads;
  const auto layout = interleaved_layout("a", {{40, 30, 20}}, ScalarType::int16, n_components, 1);
  EXPECT_TRUE(layout);
  Image image{.path = "a", .format = {}, .frame_note = {}, .grid = {}, .fields = {}};
  image.grid.dims = {{40, 30, 20}};
  image.tally = std::make_shared<IoTally>();
  image.fields.push_back({.name = {}, .layout = *layout, .slope = slope, .load = [&reads] {
                            return std::unique_ptr<SampleStore>(
                                std::make_unique<WatchedStore>(reads));
                          }});
  ReadOptions options;
  if (n_components > 1) options.component = Magnitude{};
  const auto source = make_image_source(image, options);
  EXPECT_TRUE(source);
  std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) *
                             size_of((*source)->info().type));
  EXPECT_TRUE((*source)->read(box, out));
  return reads;
}

TEST(volume_counts, a_box_of_whole_rows_takes_one_read_a_slice) {
  const IndexBox rows{{{0, 3, 5}}, {{40, 13, 8}}};
  constexpr std::uint64_t kOne = 40 * 10 * 2;
  const std::vector<std::uint64_t> one_each(3, kOne);
  EXPECT_EQ(reads_of(rows, 1, 1), one_each);
  EXPECT_EQ(reads_of(rows, 1, 2), one_each);
  EXPECT_EQ(reads_of(rows, 3, 1), std::vector<std::uint64_t>(3, 3 * kOne));
}

TEST(volume_counts, whole_slices_take_one_read_in_all_and_parts_of_rows_one_each) {
  EXPECT_EQ(reads_of({{{0, 0, 5}}, {{40, 30, 8}}}, 1, 1),
            std::vector<std::uint64_t>{40 * 30 * 3 * 2});
  EXPECT_EQ(reads_of({{{1, 3, 5}}, {{40, 13, 7}}}, 1, 1), std::vector<std::uint64_t>(20, 39 * 2));
}

TEST(volume_counts, samples_decoded_at_opening_are_read_from_the_file_once) {
  const TempDir dir;
  const std::string bytes = test::gzipped(test::bytes_of(ramp<std::int16_t>(24)));
  ReadOptions options;
  options.raw = RawLayout{.dims = {{4, 3, 2}}, .type = ScalarType::int16};
  const auto source = open_volume(dir.write("a.raw.gz", bytes), options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->io().n_file_bytes_read, bytes.size());
  EXPECT_EQ(file_bytes_of(**source, {{{0, 0, 0}}, {{4, 3, 2}}}), 0U);
}

TEST(volume_counts, detached_headers_count_with_their_data) {
  const TempDir dir;
  dir.write("a.img", test::bytes_of(ramp<std::int16_t>(24)));
  test::NiftiBytes header({4, 3, 2}, 4);
  header.set_text(344, "ni1").set<float>(108, 0);
  const auto source = open_volume(dir.write("a.hdr", header.bytes()), {});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->io().n_file_bytes_read, header.bytes().size());
  EXPECT_EQ(file_bytes_of(**source, {{{0, 0, 0}}, {{4, 3, 2}}}), 48U);
}

TEST(volume_counts, samples_in_memory_count_nothing) {
  const Volume volume = make_volume<std::int16_t>({.dims = {{4, 3, 2}}}, ramp<std::int16_t>(24));
  const auto source = make_memory_source(volume);
  EXPECT_EQ(file_bytes_of(*source, {{{0, 0, 0}}, {{4, 3, 2}}}), 0U);
}

}  // namespace
}  // namespace lode::io
