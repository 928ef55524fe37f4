// Damaged files: what is whole comes back as it was, and what is filled is within its bounds.
#include "lode/models/diamond/salvage.h"

#include <array>

#include "lode/api/dataset.h"
#include "lode/models/diamond/attribute_check.h"
#include "tests/models/salvage_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::diamond {
namespace {

using store::TestPath;
using test::Bytes;
using test::Holes;
using test::StoredFile;

enum class Pattern { noise, waves };
struct SalvageCase {
  Index3 dims;
  ScalarType type = ScalarType::uint8;
  Pattern pattern = Pattern::noise;
  Holes holes = Holes::none;

  friend void PrintTo(const SalvageCase& c, std::ostream* out) {
    *out << fmt::format("{} x {} x {} {} {}{}", c.dims[0], c.dims[1], c.dims[2], name_of(c.type),
                        c.pattern == Pattern::noise ? "noise" : "waves",
                        c.holes == Holes::some ? " with holes" : "");
  }
};

class salvaged_file : public ::testing::TestWithParam<SalvageCase> {
 protected:
  void SetUp() override {
    const SalvageCase& c = GetParam();
    volume_ = c.pattern == Pattern::noise ? test::random_samples(c.dims, c.type, c.holes)
                                          : test::wavy_samples(c.dims, c.type);
  }
  [[nodiscard]] bool is_flat() const {
    return std::min({volume_.info.grid.dims[0], volume_.info.grid.dims[1],
                     volume_.info.grid.dims[2]}) == 1;
  }

  Volume volume_;
};

/// What a salvaged model must be, given the original samples and the blocks that were damaged.
template <int D>
void expect_within_bounds(const Volume& original, const StoredFile& file,
                          const std::set<std::size_t>& damaged, const Salvaged<D>& salvaged) {
  const SalvageReport& report = salvaged.report;
  const Model<D>& model = salvaged.model;
  ASSERT_EQ(report.lost.size(), damaged.size());
  std::uint64_t n_lost = 0;
  std::uint64_t n_lost_holes = 0;
  std::uint64_t n_other_holes = 0;
  std::uint64_t n_wrong = 0;
  const Index3& dims = original.info.grid.dims;
  std::size_t at = 0;
  Index3 p;
  for (p[2] = 0; p[2] < dims[2]; ++p[2])
    for (p[1] = 0; p[1] < dims[1]; ++p[1])
      for (p[0] = 0; p[0] < dims[0]; ++p[0], ++at) {
        const double before = test::sample_or_nan(original, at);
        Index<D> q;
        for (std::size_t i = 0; i < as_size(D); ++i) q[i] = p[as_size(model.axes.axis[i])];
        const double sample = model.value(q);
        const double after = model.is_hole(sample) ? std::nan("") : sample;
        const auto key = test::block_of_sample(dims, p, D == 2);
        const auto block = file.find(key);
        ASSERT_TRUE(block);
        const bool is_lost = damaged.contains(*block);
        n_lost += is_lost ? 1 : 0;
        n_lost_holes += is_lost && std::isnan(before) ? 1 : 0;
        if (std::isnan(before) || std::isnan(after)) {
          n_other_holes += std::isnan(before) != std::isnan(after) ? 1 : 0;
          n_wrong += std::isnan(before) != std::isnan(after) && !is_lost ? 1 : 0;
          continue;
        }
        if (!is_floating(original.info.type)) n_wrong += after != std::round(after) ? 1 : 0;
        const auto lost = std::ranges::find(report.lost, key, &LostBlock::key);
        EXPECT_EQ(lost != report.lost.end(), is_lost);
        const double bound = is_lost ? lost->max_error : 0;
        n_wrong += std::abs(before - after) <= bound ? 0 : 1;
        if (before != after) {
          EXPECT_TRUE(lost->box.contains(p));
        }
      }
  EXPECT_EQ(n_wrong, 0U);
  // Copies beyond the data may have replaced some.
  EXPECT_LE(report.n_samples, n_lost);
  EXPECT_LE(report.n_lost_holes, n_lost_holes);
  EXPECT_LE(report.n_holes, report.n_samples);
  if (report.n_lost_holes == 0) EXPECT_EQ(n_other_holes, 0U);
  if (report.n_lost_holes == report.n_samples) EXPECT_EQ(n_other_holes, 0U);
}

/// What the attributes of a model promise, found again from its samples.
template <int D>
void expect_true_attributes(const Model<D>& model) {
  Progress progress;
  const auto report = check_attributes<D>(model, {2}, progress);
  ASSERT_TRUE(report);
  for (const AttributeFinding* finding :
       {&report->own_errors, &report->own_ranges, &report->nesting, &report->tightness})
    EXPECT_EQ(finding->n_wrong, 0U) << finding->worst;
}

/// Of the file at `path`.
template <int D>
void expect_salvaged_from(const std::string& path, const Volume& volume, const StoredFile& file,
                          const std::set<std::size_t>& damaged) {
  SCOPED_TRACE(fmt::format("{} of {} blocks damaged, the first {}", damaged.size(), file.n_blocks(),
                           damaged.empty() ? 0 : *damaged.begin()));
  const auto salvaged = test::salvage<D>(path);
  ASSERT_TRUE(salvaged) << salvaged.error().message;
  EXPECT_EQ(salvaged->report.n_blocks, file.n_blocks());
  expect_within_bounds<D>(volume, file, damaged, *salvaged);
}

template <int D>
void expect_salvaged(const Volume& volume, const StoredFile& file, const std::string& path,
                     const std::set<std::size_t>& damaged) {
  file.write_damaged(path, damaged);
  expect_salvaged_from<D>(path, volume, file, damaged);
}

template <int D>
void expect_each_block_salvaged(const Volume& volume) {
  const TestPath path("salvage.lode");
  test::save<D>(test::built<D>(volume), path.str());
  const StoredFile file(path.str());
  for (std::size_t i = 0; i < file.n_blocks(); ++i)
    expect_salvaged<D>(volume, file, path.str(), {i});
}

TEST_P(salvaged_file, is_within_its_bounds_whichever_block_is_damaged) {
  if (is_flat())
    expect_each_block_salvaged<2>(volume_);
  else
    expect_each_block_salvaged<3>(volume_);
}

template <int D>
void expect_sets_salvaged(const Volume& volume) {
  const TestPath path("salvage.lode");
  const Model<D> model = test::built<D>(volume);
  test::save<D>(model, path.str());
  const StoredFile file(path.str());
  std::vector<std::set<std::size_t>> sets(2);  // [1]: all
  for (std::uint32_t level = 0; level < static_cast<std::uint32_t>(model.shape.n_levels); ++level)
    for (const bool with_nodes : {false, true}) {
      sets.emplace_back();
      for (std::size_t i = 0; i < file.n_blocks(); ++i)
        if (file.blocks[i].key.level == level && (with_nodes || file.is_samples(i)))
          sets.back().insert(i);
    }
  for (std::size_t i = 0; i < file.n_blocks(); ++i) sets[1].insert(i);
  oracles::Random random(3);
  for (int n = 0; n < 3; ++n) {
    sets.emplace_back();
    for (std::size_t i = 0; i < file.n_blocks(); ++i)
      if (random.below(4) == 0) sets.back().insert(i);
  }
  for (const auto& damaged : sets) expect_salvaged<D>(volume, file, path.str(), damaged);
}

TEST_P(salvaged_file, is_within_its_bounds_whatever_is_damaged_together) {
  if (is_flat())
    expect_sets_salvaged<2>(volume_);
  else
    expect_sets_salvaged<3>(volume_);
}

template <int D>
void expect_all_but_samples_restored(const Volume& volume) {
  const TestPath path("salvage.lode");
  const TestPath again("again.lode");
  test::save<D>(test::built<D>(volume), path.str());
  const StoredFile file(path.str());
  std::set<std::size_t> damaged;
  for (std::size_t i = 0; i < file.n_blocks(); ++i)
    if (!file.is_samples(i)) damaged.insert(i);
  file.write_damaged(path.str(), damaged);
  const auto salvaged = test::salvage<D>(path.str());
  ASSERT_TRUE(salvaged) << salvaged.error().message;
  EXPECT_EQ(salvaged->report.lost.size(), damaged.size());
  EXPECT_EQ(salvaged->report.n_samples, 0U);
  EXPECT_EQ(salvaged->report.max_error, 0);
  test::save<D>(salvaged->model, again.str());
  EXPECT_TRUE(store::load_file(again.str()) == file.bytes);
}

TEST_P(salvaged_file, comes_back_to_the_byte_where_no_sample_is_lost) {
  if (is_flat())
    expect_all_but_samples_restored<2>(volume_);
  else
    expect_all_but_samples_restored<3>(volume_);
}

INSTANTIATE_TEST_SUITE_P(
    cases, salvaged_file,
    ::testing::Values(SalvageCase{{{1, 1, 1}}}, SalvageCase{{{5, 1, 1}}, ScalarType::float32},
                      SalvageCase{{{2, 2, 2}}}, SalvageCase{{{6, 4, 3}}, ScalarType::int8},
                      SalvageCase{{{17, 9, 12}}, ScalarType::float32, Pattern::noise, Holes::some},
                      SalvageCase{{{35, 20, 18}}, ScalarType::uint8, Pattern::noise, Holes::some},
                      SalvageCase{{{34, 24, 33}}, ScalarType::int16, Pattern::waves},
                      SalvageCase{{{33, 18, 19}}, ScalarType::float32, Pattern::waves},
                      SalvageCase{{{66, 3, 65}}, ScalarType::uint16, Pattern::noise, Holes::some},
                      SalvageCase{{{67, 7, 2}}, ScalarType::float64},
                      SalvageCase{{{2, 2, 67}}, ScalarType::int32, Pattern::noise, Holes::some},
                      SalvageCase{{{40, 10, 9}}, ScalarType::uint64, Pattern::waves},
                      SalvageCase{{{1, 40, 33}}, ScalarType::uint16},
                      SalvageCase{{{514, 1, 9}}, ScalarType::float32, Pattern::noise, Holes::some},
                      SalvageCase{{{516, 12, 1}}, ScalarType::uint8, Pattern::waves}));

class truncated_file : public salvaged_file {
 protected:
  /// Cut off there; bit flips before that are the caller's.
  template <int D>
  void expect_salvaged_as_far_as_it_is_there(const StoredFile& file, const Bytes& bytes) {
    SCOPED_TRACE(fmt::format("{} of {} bytes", bytes.size(), file.bytes.size()));
    store::save_file(path_.str(), bytes);
    const auto refused = store::Reader::open(path_.str());
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().message.starts_with(path_.str() + ": "));
    const auto is_whole = [&](const store::BlockEntry& block) {
      const std::uint64_t end = block.offset + block.stored_size;
      return end <= bytes.size() &&
             std::equal(bytes.begin() + static_cast<std::ptrdiff_t>(block.offset),
                        bytes.begin() + static_cast<std::ptrdiff_t>(end),
                        file.bytes.begin() + static_cast<std::ptrdiff_t>(block.offset));
    };
    std::set<std::size_t> lost;
    bool is_index_whole = false;
    std::size_t i = 0;
    for (const store::BlockEntry& block : file.reader.blocks())
      if (store::is_index(block.key))
        is_index_whole = is_whole(block);
      else if (const std::size_t number = i++; !is_index_whole || !is_whole(block))
        lost.insert(number);
    if (std::ranges::any_of(file.indexes, is_whole))
      return expect_salvaged_from<D>(path_.str(), volume_, file, lost);
    const auto salvaged = test::salvage<D>(path_.str());
    ASSERT_FALSE(salvaged);
    EXPECT_TRUE(salvaged.error().message.starts_with(path_.str() + ": "));
  }
  template <int D>
  void expect_salvaged_wherever_it_is_cut() {
    test::save<D>(test::built<D>(volume_), path_.str());
    const StoredFile file(path_.str());
    std::vector<std::uint64_t> ends{0, 7, store::kHeaderBytes - 1, file.bytes.size() - 1};
    const int n_in_each = oracles::trials(3, 1);  // of which each is in some block
    int next = 0;
    for (const store::BlockEntry& block : file.reader.blocks())
      for (int i = 0; i < n_in_each; ++i, ++next)
        ends.push_back(block.offset + std::array{std::uint64_t{0}, std::uint64_t{1},
                                                 std::uint64_t{block.stored_size / 2}}[next % 3]);
    ends.push_back(store::end_of(file.reader.blocks()));
    for (const std::uint64_t end : ends)
      expect_salvaged_as_far_as_it_is_there<D>(
          file, {file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(end)});
  }
  template <int D>
  void expect_runs_lost_with_their_indexes() {
    test::save<D>(test::built<D>(volume_), path_.str());
    const StoredFile file(path_.str());
    const std::uint64_t end = store::end_of(file.reader.blocks());
    for (const store::BlockEntry& index : file.indexes)
      for (const std::uint64_t at : {std::uint64_t{3}, std::uint64_t{40}, index.stored_size - 1}) {
        Bytes bytes{file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(end)};
        bytes[index.offset + at] ^= std::byte{0x40};
        expect_salvaged_as_far_as_it_is_there<D>(file, bytes);
      }
  }
  /// With indexes alone, but every block whole; and with the directory, but no index.
  template <int D>
  void expect_restored() {
    const TestPath again("again.lode");
    test::save<D>(test::built<D>(volume_), path_.str());
    const StoredFile file(path_.str());
    const auto expect_same = [&](const Bytes& bytes) {
      store::save_file(path_.str(), bytes);
      const auto salvaged = test::salvage<D>(path_.str());
      ASSERT_TRUE(salvaged) << salvaged.error().message;
      EXPECT_TRUE(salvaged->report.lost.empty());
      test::save<D>(salvaged->model, again.str());
      EXPECT_TRUE(store::load_file(again.str()) == file.bytes);
    };
    Bytes bytes = file.bytes;
    bytes.resize(store::end_of(file.reader.blocks()) + 5);
    expect_same(bytes);
    bytes = file.bytes;
    bytes[50] ^= std::byte{1};  // of the header
    expect_same(bytes);
    bytes = file.bytes;
    for (const store::BlockEntry& index : file.indexes) bytes[index.offset] ^= std::byte{1};
    expect_same(bytes);
    EXPECT_TRUE(test::load<D>(path_.str()));
    EXPECT_NE(store::open_and_check(path_.str()), "");
  }

  TestPath path_{"truncated.lode"};
};

TEST_P(truncated_file, is_within_its_bounds_wherever_it_is_cut) {
  if (is_flat())
    expect_salvaged_wherever_it_is_cut<2>();
  else
    expect_salvaged_wherever_it_is_cut<3>();
}

TEST_P(truncated_file, loses_the_blocks_of_indexes_that_are_damaged) {
  if (is_flat())
    expect_runs_lost_with_their_indexes<2>();
  else
    expect_runs_lost_with_their_indexes<3>();
}

TEST_P(truncated_file, comes_back_to_the_byte_where_all_blocks_are_whole) {
  if (is_flat())
    expect_restored<2>();
  else
    expect_restored<3>();
}

INSTANTIATE_TEST_SUITE_P(
    cases, truncated_file,
    ::testing::Values(SalvageCase{{{1, 1, 1}}}, SalvageCase{{{9, 8, 7}}, ScalarType::int16},
                      SalvageCase{{{35, 20, 18}}, ScalarType::uint8, Pattern::noise, Holes::some},
                      SalvageCase{{{34, 24, 33}}, ScalarType::float32, Pattern::waves},
                      SalvageCase{{{4, 3, 520}}, ScalarType::uint16, Pattern::waves},
                      SalvageCase{{{260, 3, 4}}, ScalarType::float32, Pattern::noise, Holes::some},
                      SalvageCase{{{40, 33, 1}}, ScalarType::uint8, Pattern::waves},
                      SalvageCase{
                          {{2060, 1, 4}}, ScalarType::float32, Pattern::noise, Holes::some}));

TEST(salvage, of_a_file_that_says_more_samples_than_its_bytes_can_be_is_refused) {
  const TestPath path("salvage.lode");
  Volume volume = test::random_samples({{9, 8, 7}}, ScalarType::uint8, Holes::none);
  const Model<3> model = test::built<3>(volume);
  auto writer = store::Writer::create(path.str(), model_name<3>(), {});
  ASSERT_TRUE(writer);
  VolumeInfo info = volume.info;
  info.grid.dims = {{500'000, 500'000, 500'000}};
  writer->set_early_metadata(encode_early_metadata(info, model.stats));
  const std::vector<store::KeyedBlock> blocks{{{1, 0, {}}, store::encode_block({Bytes(100), 1})}};
  ASSERT_TRUE(writer->append_run(blocks));
  ASSERT_TRUE(writer->finish());
  Bytes bytes = store::load_file(path.str());
  bytes.pop_back();
  store::save_file(path.str(), bytes);
  const auto salvaged = test::salvage<3>(path.str());
  ASSERT_FALSE(salvaged);
  EXPECT_NE(salvaged.error().message.find("500000 x 500000 x 500000, too many"), std::string::npos)
      << salvaged.error().message;
}

TEST(salvage, of_a_scan_is_within_its_bounds_whichever_block_is_damaged) {
  expect_each_block_salvaged<3>(test::part_of_scan());
}

/// Blocks of few samples: the bound of each is close to what it bounds.
TEST(salvage, is_within_its_bounds_for_small_volumes_of_all_shapes) {
  const TestPath path("salvage.lode");
  oracles::Random random(29);
  for (int n = 0; n < 150; ++n) {
    Index3 dims;
    for (std::int32_t& d : dims.v) d = 1 + static_cast<std::int32_t>(random.below(9));
    dims[random.below(3)] = 1 + static_cast<std::int32_t>(random.below(2));
    const auto type = static_cast<ScalarType>(1 + random.below(10));
    Volume volume =
        test::random_samples(dims, type, random.below(3) == 0 ? Holes::some : Holes::none);
    if (random.below(2) == 0) test::poke_holes(volume, random.below(2) == 0 ? 20 : 70);
    SCOPED_TRACE(fmt::format("{}: {} x {} x {} {}", n, dims[0], dims[1], dims[2], name_of(type)));
    const auto run = [&]<int D>() {
      test::save<D>(test::built<D>(volume), path.str());
      const StoredFile file(path.str());
      for (const std::uint32_t share : {2U, 3U, 8U}) {
        std::set<std::size_t> damaged;
        for (std::size_t i = 0; i < file.n_blocks(); ++i)
          if (random.below(share) == 0) damaged.insert(i);
        expect_salvaged<D>(volume, file, path.str(), damaged);
      }
    };
    if (std::min({dims[0], dims[1], dims[2]}) == 1)
      run.template operator()<2>();
    else
      run.template operator()<3>();
  }
}

TEST(salvage, refuses_metadata_with_which_it_could_not_fill) {
  const TestPath path("salvage.lode");
  const Volume volume = test::random_samples({{9, 8, 7}}, ScalarType::uint8, Holes::none);
  test::save<3>(test::built<3>(volume), path.str());
  const Bytes original = store::load_file(path.str());
  const auto expect_refused = [&](const std::string& part, const auto& change) {
    store::save_file(path.str(), original);
    test::rewrite_decoded(path.str(), [&](Metadata& m) { change(m.summary.stats); });
    const StoredFile file(path.str());
    file.write_damaged(path.str(), {0});
    const auto salvaged = test::salvage<3>(path.str());
    ASSERT_FALSE(salvaged);
    EXPECT_TRUE(salvaged.error().message.starts_with(path.str() + ": "));
    EXPECT_NE(salvaged.error().message.find(part), std::string::npos) << salvaged.error().message;
  };
  expect_refused("a range of uint8", [](FieldStats& s) { s.min = -5; });
  expect_refused("a range of uint8", [](FieldStats& s) { s.max = 256; });
  expect_refused("expected 3 holes", [](FieldStats& s) { s.n_holes = 3; });
}

TEST(salvage, takes_older_files_with_holes_that_are_refused_otherwise) {
  const TestPath path("older.lode");
  const Volume volume = test::random_samples({{35, 20, 18}}, ScalarType::float32, Holes::some);
  test::save<3>(test::built<3>(volume), path.str());
  Bytes bytes = store::load_file(path.str());
  std::uint64_t features;
  std::memcpy(&features, bytes.data() + 16, sizeof(features));
  EXPECT_NE(features & store::kFeatureRemovedCells, 0U);
  store::patch_header(bytes, 16, features & ~store::kFeatureRemovedCells);
  store::save_file(path.str(), bytes);
  const auto loaded = test::load<3>(path.str());
  ASSERT_FALSE(loaded);
  EXPECT_NE(loaded.error().message.find("an older version of lode: build it again"),
            std::string::npos);
  EXPECT_FALSE(Dataset::open(path.str(), {2}));
  const auto salvaged = test::salvage<3>(path.str());
  ASSERT_TRUE(salvaged) << salvaged.error().message;
  EXPECT_EQ(salvaged->report.n_samples, 0U);
}

TEST(salvage, gives_a_model_whose_attributes_are_true) {
  const TestPath path("salvage.lode");
  const Volume volume = test::random_samples({{35, 20, 18}}, ScalarType::uint16, Holes::some);
  test::save<3>(test::built<3>(volume), path.str());
  const StoredFile file(path.str());
  for (std::size_t i = 0; i < file.n_blocks(); i += 3) {
    file.write_damaged(path.str(), {i, i / 2});
    const auto salvaged = test::salvage<3>(path.str());
    ASSERT_TRUE(salvaged);
    expect_true_attributes<3>(salvaged->model);
  }
}

}  // namespace
}  // namespace lode::diamond
