// Damaged files through the door: what surfaces taken out of them have to do with the original.
#include <filesystem>

#include "lode/api/dataset.h"
#include "lode/api/salvage.h"
#include "lode/models/diamond/level_set_check.h"
#include "tests/models/salvage_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using store::TestPath;
using test::Bytes;
using test::StoredFile;

Dataset salvaged(const std::string& path) {
  Progress progress;
  auto dataset = Dataset::salvage(path, {2}, progress);
  EXPECT_TRUE(dataset) << (dataset ? "" : dataset.error().message);
  return std::move(dataset).value();
}

std::string salvage_error(const std::string& path) {
  Progress progress;
  const auto dataset = Dataset::salvage(path, {2}, progress);
  return dataset ? "" : dataset.error().message;
}

/// Largest |F - isovalue| on a surface, F being the field of these samples.
double deviation(const Volume& volume, const Surface& surface, double isovalue) {
  Progress progress;
  const auto report = diamond::check_level_set(
      diamond::VolumeSamples(volume), surface,
      {.isovalues = {isovalue}, .tolerance = 1e300, .clip = {}, .threads = {2}}, progress);
  EXPECT_TRUE(report && report->holds());
  return report->max_deviation;
}

void expect_true_surface(const Volume& original, const Dataset& dataset, double isovalue,
                         double tolerance) {
  SCOPED_TRACE(fmt::format("isovalue {} within {}", isovalue, tolerance));
  const ExtractOptions options{.isovalues = {isovalue}, .max_error = tolerance, .threads = {2}};
  Surface surface;
  Progress progress;
  const auto report = dataset.extract(options, surface, progress);
  ASSERT_TRUE(report) << report.error().message;
  const auto verified = dataset.verify_surface(surface, options, progress);
  ASSERT_TRUE(verified) << verified.error().message;
  for (const VerifyReport::Check& check : verified->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
  const double bound = report->achieved_error + dataset.salvaged()->max_error;
  if (!surface.is_empty()) {
    EXPECT_LE(deviation(original, surface, isovalue), bound + 2 * report->coordinate_slack);
    return;
  }
  double low = isovalue;
  double high = isovalue;
  for (std::size_t i = 0; i < static_cast<std::size_t>(original.info.grid.n_samples()); ++i) {
    low = std::min(low, test::sample_or_nan(original, i));
    high = std::max(high, test::sample_or_nan(original, i));
  }
  EXPECT_TRUE(high <= isovalue + bound || low >= isovalue - bound);
}

struct SurfaceCase {
  Index3 dims;
  ScalarType type = ScalarType::uint8;

  friend void PrintTo(const SurfaceCase& c, std::ostream* out) {
    *out << fmt::format("{} x {} x {} {}", c.dims[0], c.dims[1], c.dims[2], name_of(c.type));
  }
};

class salvaged_surface : public ::testing::TestWithParam<SurfaceCase> {
 protected:
  void SetUp() override {
    if (is_flat())
      test::save<2>(test::built<2>(volume_), path_.str());
    else
      test::save<3>(test::built<3>(volume_), path_.str());
  }
  [[nodiscard]] static bool is_flat() {
    const Index3& dims = GetParam().dims;
    return std::min({dims[0], dims[1], dims[2]}) == 1;
  }

  Volume volume_ = test::wavy_samples(GetParam().dims, GetParam().type);
  TestPath path_{"salvage.lode"};
};

TEST_P(salvaged_surface, is_whole_and_within_the_bound_of_the_original_field) {
  const StoredFile file(path_.str());
  for (std::size_t i = 0; i < file.n_blocks(); i += oracles::trials(1U, 4U)) {
    if (!file.is_samples(i)) continue;
    file.write_damaged(path_.str(), {i, (i * 7) % file.n_blocks()});
    const Dataset dataset = salvaged(path_.str());
    for (const double tolerance : {0.0, 4.0})
      expect_true_surface(volume_, dataset, 60.5, tolerance);
  }
}

TEST_P(salvaged_surface, is_that_of_the_whole_file_outside_the_lost_boxes) {
  // There the full-resolution surface has the same vertices.
  const StoredFile file(path_.str());
  Progress progress;
  Surface whole;
  const auto intact = Dataset::open(path_.str(), {2});
  ASSERT_TRUE(intact);
  ASSERT_TRUE(intact->extract({.isovalues = {60.5}, .max_error = 0}, whole, progress));
  std::set<std::size_t> damaged;
  for (std::size_t i = 0; i < file.n_blocks(); ++i)
    if (file.is_samples(i) && file.blocks[i].key.level == 0 && damaged.empty()) damaged.insert(i);
  file.write_damaged(path_.str(), damaged);
  const Dataset dataset = salvaged(path_.str());
  Surface surface;
  ASSERT_TRUE(dataset.extract({.isovalues = {60.5}, .max_error = 0}, surface, progress));
  ASSERT_TRUE(dataset.salvaged()->box);
  const Box3d box = *dataset.salvaged()->box;
  const auto outside = [&](const Surface& from) {
    std::vector<std::array<float, 3>> points;
    for (const Vec3f& p : from.positions) {
      bool is_inside = true;
      for (std::size_t a = 0; a < 3; ++a) {
        const double x = static_cast<double>(p[a]) + from.origin[a];
        is_inside = is_inside && x >= box.lower[a] && x <= box.upper[a];
      }
      if (!is_inside) points.push_back(p.v);
    }
    std::sort(points.begin(), points.end());
    return points;
  };
  EXPECT_TRUE(outside(surface) == outside(whole));
}

INSTANTIATE_TEST_SUITE_P(cases, salvaged_surface,
                         ::testing::Values(SurfaceCase{{{34, 26, 20}}, ScalarType::int16},
                                           SurfaceCase{{{70, 20, 21}}, ScalarType::uint8},
                                           SurfaceCase{{{33, 18, 36}}, ScalarType::float32},
                                           SurfaceCase{{{530, 40, 1}}, ScalarType::float64}));

class damaged_model : public ::testing::Test {
 protected:
  void SetUp() override { test::save<3>(test::built<3>(volume_), path_.str()); }
  void write(const Bytes& bytes) const { store::save_file(path_.str(), bytes); }

  Volume volume_ = test::wavy_samples({{40, 33, 20}}, ScalarType::uint8);
  TestPath path_{"salvage.lode"};
};

TEST_F(damaged_model, that_is_whole_is_salvaged_without_loss) {
  const Dataset dataset = salvaged(path_.str());
  ASSERT_NE(dataset.salvaged(), nullptr);
  EXPECT_TRUE(dataset.salvaged()->blocks.empty());
  EXPECT_FALSE(dataset.salvaged()->box);
  EXPECT_GT(dataset.salvaged()->n_blocks, 0U);
  const auto intact = Dataset::open(path_.str(), {2});
  ASSERT_TRUE(intact);
  EXPECT_EQ(intact->salvaged(), nullptr);
  EXPECT_EQ(intact->describe().base_error, dataset.describe().base_error);
}

TEST_F(damaged_model, that_was_cut_off_is_salvaged_as_far_as_it_is_there) {
  const StoredFile file(path_.str());
  for (const store::BlockEntry& block : file.blocks) {
    write({file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(block.offset)});
    EXPECT_FALSE(Dataset::open(path_.str(), {2}));
    EXPECT_TRUE(can_salvage(path_.str()));
    const Dataset dataset = salvaged(path_.str());
    std::size_t n_lost = 0;
    for (const store::BlockEntry& b : file.blocks) n_lost += b.offset >= block.offset ? 1 : 0;
    EXPECT_EQ(dataset.salvaged()->blocks.size(), n_lost);
    EXPECT_EQ(dataset.salvaged()->n_blocks, file.n_blocks());
    expect_true_surface(volume_, dataset, 60.5, 4);
  }
}

TEST_F(damaged_model, that_was_cut_off_before_its_blocks_says_so) {
  const StoredFile file(path_.str());
  const std::uint64_t first = file.indexes.at(0).offset + file.indexes.at(0).stored_size;
  const std::vector<std::uint64_t> ends{1, 100, store::kHeaderBytes, first - 1};
  for (const std::uint64_t end : ends) {
    write({file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(end)});
    const std::string message = salvage_error(path_.str());
    EXPECT_TRUE(message.starts_with(path_.str() + ": ")) << message;
    if (end < store::kMagicBytes) continue;
    EXPECT_FALSE(can_salvage(path_.str()));
    EXPECT_NE(message.find("truncated"), std::string::npos) << message;
    EXPECT_NE(message.find("nothing can be salvaged"), std::string::npos) << message;
  }
}

TEST_F(damaged_model, with_zeros_from_a_block_to_the_directory_is_salvaged) {
  // As files come out of transfers that made room first.
  const StoredFile file(path_.str());
  const auto& blocks = file.blocks;
  const std::uint64_t end = blocks.back().offset + blocks.back().stored_size;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    Bytes bytes = file.bytes;
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(blocks[i].offset),
              bytes.begin() + static_cast<std::ptrdiff_t>(end), std::byte{0});
    write(bytes);
    const Dataset dataset = salvaged(path_.str());
    EXPECT_EQ(dataset.salvaged()->blocks.size(), blocks.size() - i);
    expect_true_surface(volume_, dataset, 60.5, 4);
  }
}

TEST_F(damaged_model, that_misses_a_byte_between_its_blocks_loses_one_of_them) {
  const StoredFile file(path_.str());
  for (const store::BlockEntry& block : file.blocks) {
    Bytes bytes = file.bytes;
    bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(block.offset + block.stored_size / 2));
    write(bytes);
    const Dataset dataset = salvaged(path_.str());
    ASSERT_EQ(dataset.salvaged()->blocks.size(), 1U);
    EXPECT_EQ(dataset.salvaged()->blocks[0].level, static_cast<int>(block.key.level));
  }
}

TEST_F(damaged_model, of_which_the_rest_cannot_be_read_any_more_loses_that) {
  const StoredFile file(path_.str());
  const auto& blocks = file.blocks;
  for (std::size_t i = 0; i < blocks.size(); i += 3) {
    write(file.bytes);
    const auto reader = store::Reader::open(path_.str());
    ASSERT_TRUE(reader);
    std::filesystem::resize_file(path_.str(), blocks[i].offset);
    Progress progress;
    const auto found = diamond::salvage<3>(*reader, {2}, progress);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->report.lost.size(), blocks.size() - i);
    for (const diamond::LostBlock& lost : found->report.lost)
      EXPECT_NE(lost.reason.find("truncated"), std::string::npos) << lost.reason;
  }
}

TEST_F(damaged_model, with_bytes_after_its_end_is_whole) {
  Bytes bytes = store::load_file(path_.str());
  bytes.resize(bytes.size() + 777);
  write(bytes);
  EXPECT_FALSE(Dataset::open(path_.str(), {2}));
  EXPECT_TRUE(salvaged(path_.str()).salvaged()->blocks.empty());
}

TEST_F(damaged_model, without_directory_and_indexes_is_refused) {
  test::rewrite(path_.str(), {});  // as files were before they had indexes
  const Bytes original = store::load_file(path_.str());
  EXPECT_TRUE(salvaged(path_.str()).salvaged()->blocks.empty());
  for (const std::size_t at : {std::size_t{40}, original.size() - 5}) {
    Bytes bytes = original;
    bytes[at] ^= std::byte{1};
    write(bytes);
    EXPECT_FALSE(can_salvage(path_.str()));
    EXPECT_NE(salvage_error(path_.str()).find("nothing can be salvaged"), std::string::npos);
  }
  write(store::to_bytes("NRRD0004 and so on"));
  EXPECT_NE(salvage_error(path_.str()).find("not a .lode file"), std::string::npos);
  EXPECT_EQ(salvage_error(path_.str()).find("salvaged"), std::string::npos);
}

TEST_F(damaged_model, says_which_levels_and_blocks_are_lost_and_why) {
  const StoredFile file(path_.str());
  std::set<std::size_t> damaged;
  for (std::size_t i = 0; i < file.n_blocks(); ++i)
    if (file.blocks[i].key.level == 1) damaged.insert(i);
  file.write_damaged(path_.str(), damaged);
  const Dataset dataset = salvaged(path_.str());
  const SalvageReport& report = *dataset.salvaged();
  EXPECT_EQ(report.n_blocks, file.n_blocks());
  ASSERT_EQ(report.blocks.size(), 5U);
  ASSERT_EQ(report.levels.size(), 1U);
  EXPECT_EQ(report.levels[0].level, 1);
  EXPECT_EQ(report.levels[0].n_blocks, 5U);
  EXPECT_EQ(report.levels[0].n_samples, report.n_samples);
  EXPECT_EQ(report.levels[0].max_error, report.max_error);
  std::set<std::string> kinds;
  for (const LostBlock& block : report.blocks) {
    kinds.insert(block.kind);
    EXPECT_EQ(block.box.has_value(), block.kind == "samples");
    EXPECT_NE(block.reason.find("expected checksum"), std::string::npos) << block.reason;
  }
  EXPECT_EQ(kinds,
            (std::set<std::string>{"errors", "maxima", "minima", "samples", "world errors"}));
  // Nothing but the coarser levels and the metadata bound what is lost, yet far below the range.
  EXPECT_GT(report.max_error, 0);
  EXPECT_LT(report.max_error, 0.5 * (dataset.describe().range_max - dataset.describe().range_min));
}

TEST_F(damaged_model, is_the_same_for_any_number_of_threads) {
  const StoredFile file(path_.str());
  const TestPath again("again.lode");
  file.write_damaged(path_.str(), {0, 2, file.n_blocks() - 1});
  Bytes first;
  for (const int n_threads : {1, 2, 7}) {
    const auto found = test::salvage<3>(path_.str(), n_threads);
    ASSERT_TRUE(found);
    test::save<3>(found->model, again.str());
    if (first.empty()) first = store::load_file(again.str());
    EXPECT_TRUE(store::load_file(again.str()) == first);
  }
}

/// Files whose checksums are right, but not what they hold.
TEST_F(damaged_model, loses_blocks_that_contradict_the_metadata) {
  const StoredFile file(path_.str());
  for (const std::uint32_t kind : {1U, 2U, 3U, 4U}) {
    write(file.bytes);
    test::rewrite(path_.str(), {}, [&](const store::BlockKey& key, Bytes& raw) {
      if (key.kind != kind || key.level != 1) return;
      // Samples beyond the largest, errors that are none, ranges beyond the field's.
      std::fill(raw.begin(), raw.end(), kind == 3 ? std::byte{0} : std::byte{0xFF});
    });
    const Dataset dataset = salvaged(path_.str());
    ASSERT_EQ(dataset.salvaged()->blocks.size(), 1U) << kind;
    expect_true_surface(volume_, dataset, 60.5, 4);
  }
}

TEST_F(damaged_model, whose_metadata_are_wrong_is_refused) {
  test::rewrite_decoded(path_.str(), [](diamond::Metadata& m) { m.summary.base_error *= 2; });
  EXPECT_NE(salvage_error(path_.str()).find("base error"), std::string::npos);
}

TEST_F(damaged_model, stops_when_cancelled) {
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(Dataset::salvage(path_.str(), {2}, progress));
}

TEST(salvaged_data, of_a_scan_gives_surfaces_within_the_bound_of_the_original_field) {
  const TestPath path("salvage.lode");
  const Volume volume = test::part_of_scan();
  test::save<3>(test::built<3>(volume), path.str());
  const StoredFile file(path.str());
  for (std::size_t i = 0; i < file.n_blocks(); i += 7) {
    file.write_damaged(path.str(), {i, file.n_blocks() - 1 - i});
    expect_true_surface(volume, salvaged(path.str()), 600, 25);
  }
}

TEST(salvaged_data, that_are_smooth_have_bounds_far_below_their_range) {
  const TestPath path("salvage.lode");
  const Volume volume = test::wavy_samples({{70, 66, 40}}, ScalarType::float32);
  test::save<3>(test::built<3>(volume), path.str());
  const StoredFile file(path.str());
  for (std::size_t i = 0; i < file.n_blocks(); ++i) {
    if (!file.is_samples(i) || file.blocks[i].key.level > 1) continue;
    file.write_damaged(path.str(), {i});
    const Dataset dataset = salvaged(path.str());
    const double range = dataset.describe().range_max - dataset.describe().range_min;
    EXPECT_LT(dataset.salvaged()->max_error, 0.2 * range);
  }
}

}  // namespace
}  // namespace lode
