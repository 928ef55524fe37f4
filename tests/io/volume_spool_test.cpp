#include <random>

#include "tests/io/volume_spool_files.h"

namespace lode::io {
namespace {

using test::kSpoolDims;
using test::read_box;
using test::spooling;
using test::SpoolSeed;
using test::TempDir;

/// The two passes of an out-of-core build: slices upwards, then overlapping boxes of whole rows.
std::vector<IndexBox> passes(const Index3& dims) {
  std::vector<IndexBox> boxes;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    boxes.push_back({{{0, 0, z}}, {{dims[0], dims[1], z + 1}}});
  constexpr std::int32_t kStep = 16;
  constexpr std::int32_t kOverlap = 3;
  for (std::int32_t z = 0; z < dims[2]; z += kStep)
    for (std::int32_t y = 0; y < dims[1]; y += kStep)
      boxes.push_back({{{0, y, z}},
                       {{dims[0], std::min(y + kStep + kOverlap, dims[1]),
                         std::min(z + kStep + kOverlap, dims[2])}}});
  return boxes;
}

class volume_spool : public testing::TestWithParam<SpoolSeed> {
 protected:
  volume_spool() {
    for (const auto& [name, bytes] : contents_) path_ = files_.write(name, bytes);
    std::filesystem::create_directory(files_.path("spool"));
    options_ = GetParam().options;
  }

  [[nodiscard]] std::unique_ptr<VolumeSource> open_spooling() const {
    auto source = open_volume(path_, spooling(options_, files_.path("spool")));
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }

  void expect_same_boxes(const std::vector<IndexBox>& boxes) const {
    const auto whole = test::read_volume(path_, options_);
    ASSERT_TRUE(whole) << whole.error().message;
    const auto expected = make_memory_source(*whole);
    const auto source = open_spooling();
    ASSERT_NE(source, nullptr);
    for (const IndexBox& box : boxes) ASSERT_EQ(read_box(*source, box), read_box(*expected, box));
    EXPECT_TRUE(std::filesystem::is_empty(files_.path("spool")));
  }

  const test::SpoolFiles contents_ = GetParam().make_files();
  TempDir files_;
  std::string path_;
  ReadOptions options_;
};

TEST_P(volume_spool, gives_both_passes_the_samples_that_memory_holds) {
  expect_same_boxes(passes(kSpoolDims));
}

TEST_P(volume_spool, gives_boxes_in_any_order) {
  constexpr std::uint64_t kSeed = 20261122;
  SCOPED_TRACE(fmt::format("seed {}", kSeed));
  std::mt19937_64 random(kSeed);
  std::vector<IndexBox> boxes;
  for (int i = 0; i < 60; ++i) {
    IndexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto n = static_cast<std::uint64_t>(kSpoolDims[axis]);
      const auto a = static_cast<std::int32_t>(random() % n);
      const auto b = static_cast<std::int32_t>(random() % n);
      box.lower[axis] = std::min(a, b);
      box.upper[axis] = std::max(a, b) + 1;
    }
    boxes.push_back(box);
  }
  expect_same_boxes(boxes);
}

TEST_P(volume_spool, moves_each_byte_once_and_reads_back_what_is_read_again) {
  const auto source = open_spooling();
  ASSERT_NE(source, nullptr);
  const auto boxes = passes(kSpoolDims);
  const auto n_slices = static_cast<std::size_t>(kSpoolDims[2]);
  for (std::size_t i = 0; i < n_slices; ++i) (void)read_box(*source, boxes[i]);
  const IoCounts first = source->io();
  EXPECT_LE(first.n_file_bytes_read, GetParam().most_file_bytes(contents_) + 4096);
  EXPECT_EQ(first.n_spool_bytes_read, 0U);
  for (std::size_t i = n_slices; i < boxes.size(); ++i) (void)read_box(*source, boxes[i]);
  const IoCounts second = source->io();
  if (GetParam().is_spooled) {
    // In blocks, no longer than they were, and none twice for one box.
    EXPECT_LE(first.n_spool_bytes_written, GetParam().n_bytes);
    EXPECT_LE(second.n_spool_bytes_read, (boxes.size() - n_slices) * GetParam().n_bytes);
    EXPECT_EQ(second.n_file_bytes_read, first.n_file_bytes_read);
    EXPECT_EQ(second.n_spool_bytes_written, first.n_spool_bytes_written);
  } else {
    EXPECT_EQ(second.n_spool_bytes_written, 0U);
    EXPECT_EQ(second.n_spool_bytes_read, 0U);
  }
}

TEST_P(volume_spool, needs_a_directory_that_takes_files) {
  for (const std::string& directory : {files_.path("gone"), std::string("/proc")}) {
    const auto source = open_volume(path_, spooling(options_, directory));
    ASSERT_EQ(source.has_value(), !GetParam().is_spooled);
    if (source) continue;
    EXPECT_NE(source.error().message.find(directory + ": no spool file"), std::string::npos)
        << source.error().message;
    EXPECT_NE(source.error().message.find("memory limit of 20 bytes"), std::string::npos);
  }
}

TEST_P(volume_spool, decodes_while_opening_what_fits) {
  ReadOptions options = spooling(options_, files_.path("gone"));
  options.memory_limit = GetParam().n_bytes;
  const auto source = open_volume(path_, options);
  ASSERT_TRUE(source) << source.error().message;
  const std::uint64_t n_opened = (*source)->io().n_file_bytes_read;
  (void)read_box(**source, (*source)->info().grid.index_box());
  EXPECT_EQ((*source)->io().n_file_bytes_read, n_opened);
}

class volume_spool_truncated : public volume_spool {};

TEST_P(volume_spool_truncated, finds_damage_at_the_read_that_reaches_it) {
  const Index3 dims = kSpoolDims;
  // Two thirds of the way: the data are noise, so the place in the file is the place in the volume.
  const auto& [name, bytes] =
      *std::ranges::max_element(contents_, {}, [](const auto& file) { return file.second.size(); });
  files_.write(name, bytes.substr(0, bytes.size() / 3 * 2));
  const auto source = open_spooling();
  ASSERT_NE(source, nullptr);
  std::vector<std::byte> slice(static_cast<std::size_t>(dims[0]) *
                               static_cast<std::size_t>(dims[1]) * size_of(source->info().type));
  std::int32_t z = 0;
  Result<void> status;
  for (; z < dims[2] && status; ++z)
    status = source->read({{{0, 0, z}}, {{dims[0], dims[1], z + 1}}}, slice);
  ASSERT_FALSE(status);
  EXPECT_GT(z, dims[2] / 2);
  EXPECT_LT(z, dims[2] * 3 / 4);
  EXPECT_NE(status.error().message.find(name), std::string::npos) << status.error().message;
  EXPECT_NE(status.error().message.find("too early"), std::string::npos) << status.error().message;
  // What was decoded stays readable, what was not stays lost.
  EXPECT_TRUE(source->read({{{0, 0, 0}}, {{dims[0], dims[1], 1}}}, slice));
  const auto again = source->read({{{0, 0, dims[2] - 1}}, {{dims[0], dims[1], dims[2]}}}, slice);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().message, status.error().message);
  EXPECT_TRUE(std::filesystem::is_empty(files_.path("spool")));
}

std::string name_of_spool_seed(const testing::TestParamInfo<SpoolSeed>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(formats, volume_spool, testing::ValuesIn(test::spool_seeds()),
                         name_of_spool_seed);
INSTANTIATE_TEST_SUITE_P(vtk, volume_spool, testing::ValuesIn(test::vtk_spool_seeds()),
                         name_of_spool_seed);
INSTANTIATE_TEST_SUITE_P(parts, volume_spool, testing::ValuesIn(test::part_spool_seeds()),
                         name_of_spool_seed);
INSTANTIATE_TEST_SUITE_P(formats, volume_spool_truncated, testing::ValuesIn(test::spool_seeds()),
                         name_of_spool_seed);

}  // namespace
}  // namespace lode::io
