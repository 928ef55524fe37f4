// Models through files: what the blocks hold, and what becomes of files that lie.
#include <cstring>

#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/paged_model.h"
#include "lode/store/checksum.h"
#include "tests/models/stored_fixtures.h"
#include "tests/store/python_reader.h"

namespace lode::diamond {
namespace {

using store::TestPath;
using test::Bytes;
using test::Holes;

struct StoredCase {
  Index3 dims;
  ScalarType type = ScalarType::uint8;
  Holes holes = Holes::none;

  friend void PrintTo(const StoredCase& c, std::ostream* out) {
    *out << fmt::format("{} x {} x {} {}{}", c.dims[0], c.dims[1], c.dims[2], name_of(c.type),
                        c.holes == Holes::some ? " with holes" : "");
  }
};

class stored_model : public ::testing::TestWithParam<StoredCase> {
 protected:
  [[nodiscard]] static Volume volume() {
    Volume volume = test::random_samples(GetParam().dims, GetParam().type, GetParam().holes);
    if (GetParam().holes == Holes::some)
      volume.info.units = {.length = "mm", .value = "g/cm\u00b3"};
    return volume;
  }
  [[nodiscard]] static bool is_flat() {
    const Index3& dims = GetParam().dims;
    return std::min({dims[0], dims[1], dims[2]}) == 1;
  }
};

template <int D>
void expect_round_trip(const Volume& volume) {
  const TestPath path("model.lode");
  const TestPath again("again.lode");
  const Model<D> model = test::built<D>(volume);
  test::save<D>(model, path.str());
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto metadata = read_metadata(*reader);
  ASSERT_TRUE(metadata) << metadata.error().message;
  EXPECT_EQ(metadata->info, volume.info);
  EXPECT_EQ(metadata->summary, summarize<D>(model));
  ASSERT_EQ(metadata->summary.max_errors.size(), model.levels.size());
  const auto loaded = test::load<D>(path.str());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->stats, model.stats);
  EXPECT_TRUE(loaded->samples == model.samples);
  for (std::size_t level = 0; level < model.levels.size(); ++level)
    EXPECT_TRUE(loaded->levels[level].error == model.levels[level].error) << level;
  test::save<D>(*loaded, again.str());
  EXPECT_TRUE(store::load_file(again.str()) == store::load_file(path.str()));
}

TEST_P(stored_model, comes_back_and_is_saved_as_the_same_bytes) {
  if (is_flat()) expect_round_trip<2>(volume());
  expect_round_trip<3>(volume());
}

/// The data's samples in their storage type.
Bytes widened(const Volume& volume) {
  const auto n = static_cast<std::size_t>(volume.info.grid.n_samples());
  Bytes bytes(n * size_of(storage_type(volume.info.type)));
  widen_samples(volume.info.type, volume.samples.data(), n, bytes.data());
  return bytes;
}

template <int D>
void expect_read_in_python(const Volume& volume) {
  const TestPath path("python.lode");
  const Model<D> model = test::built<D>(volume);
  test::save<D>(model, path.str());
  const auto run = store::run_python(LODE_INDEPENDENT_DIAMOND_READER, path.str());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  const Index3& dims = volume.info.grid.dims;
  std::uint64_t n_beyond = count_stored_samples<D>(model.shape);
  n_beyond -= static_cast<std::uint64_t>(volume.info.grid.n_samples());
  EXPECT_EQ(run.output,
            fmt::format("model {}\ndims {} {} {}\nholes {} {}\nbeyond {}\nsamples {:016x}\n",
                        model_name<D>(), dims[0], dims[1], dims[2], model.stats.n_holes,
                        model.stats.n_removed_cells, n_beyond, store::checksum(widened(volume))));
}

TEST_P(stored_model, is_read_from_the_format_document_alone) {
  if (is_flat())
    expect_read_in_python<2>(volume());
  else
    expect_read_in_python<3>(volume());
}

INSTANTIATE_TEST_SUITE_P(
    cases, stored_model,
    ::testing::Values(StoredCase{{{1, 1, 1}}}, StoredCase{{{5, 1, 1}}, ScalarType::float32},
                      StoredCase{{{2, 2, 2}}}, StoredCase{{{3, 3, 3}}, ScalarType::uint16},
                      StoredCase{{{6, 4, 3}}, ScalarType::int8},
                      StoredCase{{{17, 9, 12}}, ScalarType::float32, Holes::some},
                      StoredCase{{{35, 20, 18}}, ScalarType::uint8, Holes::some},
                      StoredCase{{{66, 3, 65}}, ScalarType::uint16, Holes::some},
                      StoredCase{{{131, 7, 2}}, ScalarType::float64},
                      StoredCase{{{2, 2, 259}}, ScalarType::int32, Holes::some},
                      StoredCase{{{1, 40, 33}}, ScalarType::uint16},
                      StoredCase{{{514, 1, 9}}, ScalarType::float32, Holes::some},
                      StoredCase{{{1027, 6, 1}}, ScalarType::uint8, Holes::some}));

TEST(stored_model, of_holes_alone_has_a_range_of_zero) {
  RegularGrid grid;
  grid.dims = {{5, 4, 3}};
  const Volume volume = make_volume<float>(grid, std::vector<float>(60, std::nanf("")));
  expect_round_trip<3>(volume);
  expect_read_in_python<3>(volume);
}

TEST(block_layout, leaves_no_plane_alone_and_covers_the_grid) {
  for (std::int32_t n = 1; n <= 1100; ++n) {
    std::int32_t end = 0;
    for (const Region<3>& r : regions_of<3>({{n, 1, 1}}, 0, false)) {
      EXPECT_EQ(r.lower[0], end);
      end = r.upper[0];
      EXPECT_GE(end - r.lower[0], std::min(n, 2));
      EXPECT_LE(end - r.lower[0], kBlockEdge<3> + 1);
    }
    EXPECT_EQ(end, n);
  }
  EXPECT_EQ(n_blocks<2>(513), 1);
  EXPECT_EQ(n_blocks<2>(514), 2);
}

TEST(block_layout, counts_the_samples_of_all_blocks) {
  for (const Index3& dims : {Index3{{1, 1, 1}}, Index3{{2, 3, 4}}, Index3{{66, 1, 40}},
                             Index3{{130, 65, 7}}, Index3{{2, 2, 700}}}) {
    const auto shape = Shape<3>::of(dims);
    std::uint64_t n = 0;
    for (const Region<3>& r : all_regions<3>(shape, Kind::samples)) n += count_points(r);
    EXPECT_EQ(n, count_stored_samples<3>(shape));
  }
}

class lying_file : public ::testing::Test {
 protected:
  void SetUp() override {
    volume_ = test::random_samples({{6, 4, 3}}, ScalarType::uint16, Holes::none);
    test::save<3>(test::built<3>(volume_), path_.str());
  }
  /// Loads the file, which must fail with a message that names it and has `part`.
  void expect_refused(const std::string& part) const {
    const auto model = test::load<3>(path_.str());
    ASSERT_FALSE(model);
    const std::string& message = model.error().message;
    EXPECT_TRUE(message.starts_with(path_.str() + ": ")) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }

  TestPath path_{"lying.lode"};
  Volume volume_;
};

TEST_F(lying_file, with_another_sample_beyond_the_data_is_refused) {
  // The grid of level 2 ends at lattice point (8, 8, 8), the data at (5, 3, 2).
  const std::uint16_t last = volume_.as<std::uint16_t>().back();
  const auto other = static_cast<std::uint16_t>(last + 1);
  test::rewrite(path_.str(), {}, [&](const store::BlockKey& key, Bytes& raw) {
    if (key.kind != static_cast<std::uint32_t>(Kind::samples) || key.level != 2) return;
    ASSERT_EQ(raw.size(), 27 * sizeof other);
    std::memcpy(raw.data() + 26 * sizeof other, &other, sizeof other);
  });
  expect_refused(fmt::format(
      "beyond the data at grid point 2 2 2: expected the nearest sample, {}, got {}", last, other));
  const auto run = store::run_python(LODE_INDEPENDENT_DIAMOND_READER, path_.str());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.output, "expected the nearest sample at (8, 8, 8)\n");
}

TEST_F(lying_file, with_another_size_is_refused) {
  test::rewrite_decoded(path_.str(), [](Metadata& m) { m.info.grid.dims = {{6, 4, 4}}; });
  expect_refused("bytes of samples for 6 x 4 x 4");
}

TEST_F(lying_file, is_refused_for_each_number_of_its_summary) {
  const Bytes original = store::load_file(path_.str());
  const auto expect_found = [&](const std::string& name, const auto& change) {
    store::save_file(path_.str(), original);
    test::rewrite_decoded(path_.str(), [&](Metadata& m) { change(m.summary); });
    expect_refused(name + ": expected ");
    expect_refused(", as the metadata says, its blocks give ");
  };
  expect_found("smallest sample", [](Summary& s) { s.stats.min -= 1; });
  expect_found("largest sample", [](Summary& s) { s.stats.max += 1; });
  expect_found("number of holes", [](Summary& s) { s.stats.n_holes = 1; });
  expect_found("number of removed cells", [](Summary& s) { s.stats.n_removed_cells = 1; });
  expect_found("base error", [](Summary& s) { s.base_error *= 2; });
  for (const std::size_t level : {0U, 1U, 2U})
    expect_found(fmt::format("largest error of level {}", level),
                 [&](Summary& s) { s.max_errors[level] = HUGE_VAL; });
}

TEST_F(lying_file, with_impossible_metadata_is_refused_without_reading_blocks) {
  const Bytes original = store::load_file(path_.str());
  const auto expect_impossible = [&](const std::string& part, const auto& change) {
    store::save_file(path_.str(), original);
    test::rewrite_decoded(path_.str(), change);
    const auto reader = store::Reader::open(path_.str());
    ASSERT_TRUE(reader);
    const auto metadata = read_metadata(*reader);
    ASSERT_FALSE(metadata) << part;
    const std::string& message = metadata.error().message;
    EXPECT_TRUE(message.starts_with(path_.str() + ": metadata: expected ")) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect_impossible("range",
                    [](Metadata& m) { std::swap(m.summary.stats.min, m.summary.stats.max); });
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    expect_impossible("range", [&](Metadata& m) { m.summary.stats.min = bad; });
    expect_impossible("range", [&](Metadata& m) { m.summary.stats.max = bad; });
  }
  expect_impossible("finite", [](Metadata& m) { m.info.grid.spacing[0] = 1e308; });
  expect_impossible("magnitude", [](Metadata& m) { m.summary.stats.max = 1e305; });
  expect_impossible("up to 72 holes", [](Metadata& m) { m.summary.stats.n_holes = 73; });
  expect_impossible("removed", [](Metadata& m) { m.summary.stats.n_removed_cells = UINT64_MAX; });
  for (const double bad : {std::nan(""), -1.0, -HUGE_VAL}) {
    expect_impossible("an error >= 0", [&](Metadata& m) { m.summary.base_error = bad; });
    expect_impossible("an error >= 0", [&](Metadata& m) { m.summary.max_errors[1] = bad; });
  }
  expect_impossible("got 8 more bytes", [](Metadata& m) { m.summary.max_errors.push_back(0); });
  expect_impossible("got only 0 bytes", [](Metadata& m) { m.summary.max_errors.pop_back(); });
}

TEST_F(lying_file, with_a_unit_that_is_no_label_is_refused) {
  volume_.info.units = {.length = "m\nm", .value = {}};
  test::save<3>(test::built<3>(volume_), path_.str());
  const auto reader = store::Reader::open(path_.str());
  ASSERT_TRUE(reader);
  const auto metadata = read_metadata(*reader);
  ASSERT_FALSE(metadata);
  EXPECT_NE(metadata.error().message.find("expected a unit"), std::string::npos);
}

TEST_F(lying_file, with_metadata_cut_anywhere_is_refused) {
  const Bytes original = store::load_file(path_.str());
  const auto reader = store::Reader::open(path_.str());
  ASSERT_TRUE(reader);
  for (std::size_t n = 0; n < reader->metadata().size(); ++n) {
    store::save_file(path_.str(), original);
    test::rewrite(path_.str(), [&](Bytes& bytes) { bytes.resize(n); });
    expect_refused("metadata: expected ");
  }
  store::save_file(path_.str(), original);
  test::rewrite(path_.str(), [](Bytes& bytes) { bytes.push_back({}); });
  expect_refused("metadata: expected the end");
}

/// The first fault of a file read page by page.
std::string fault_of_pages(const std::string& path) {
  const auto reader = store::Reader::open(path).value();
  const auto metadata = read_metadata(reader);
  if (!metadata) return metadata.error().message;
  Progress progress;
  const auto model = PagedModel<3>::open(reader, *metadata, progress);
  if (!model) return model.error().message;
  store::Fetcher::Client client((*model)->fetcher());
  std::vector<std::uint32_t> all;
  for (std::uint32_t page = 0; page < (*model)->pages().size(); ++page) all.push_back(page);
  for (const std::uint32_t page : all) client.want(page, 1);
  std::vector<std::uint32_t> fetched;
  while (fetched.size() < all.size()) {
    client.wait(store::Fetcher::Clock::now() + std::chrono::seconds(60));
    client.add_fetched(fetched);
  }
  const auto fault = (*model)->fault_of(all);
  return fault ? fault->message : "";
}

TEST(paged_file, that_lies_of_its_range_is_refused) {
  const TestPath path("paged.lode");
  for (const ScalarType type :
       {ScalarType::uint8, ScalarType::uint16, ScalarType::float32, ScalarType::float64}) {
    SCOPED_TRACE(name_of(type));
    test::save<3>(test::built<3>(test::random_samples({{70, 9, 8}}, type, Holes::none)),
                  path.str());
    const Bytes original = store::load_file(path.str());
    EXPECT_EQ(fault_of_pages(path.str()), "");
    const auto expect_refused = [&](const auto& change) {
      store::save_file(path.str(), original);
      test::rewrite_decoded(path.str(), change);
      const std::string fault = fault_of_pages(path.str());
      EXPECT_TRUE(fault.starts_with(path.str() + ": ")) << fault;
    };
    expect_refused([](Metadata& m) {
      m.summary.stats.min += 1e-3 * (m.summary.stats.max - m.summary.stats.min);
    });
    expect_refused([](Metadata& m) {
      m.summary.stats.max -= 1e-3 * (m.summary.stats.max - m.summary.stats.min);
    });
    if (size_of(type) > 2)  // others keep ranges as they are
      expect_refused(
          [](Metadata& m) { m.summary.stats.min -= m.summary.stats.max - m.summary.stats.min; });
    expect_refused([](Metadata& m) { m.info.grid.dims[0] = 30000; });
    expect_refused([](Metadata& m) { m.info.grid.dims = {{524289, 524289, 524289}}; });
  }
}

TEST(diamond2d_file, without_a_flat_axis_is_refused) {
  const TestPath path("thick.lode");
  test::save<2>(test::built<2>(test::random_samples({{4, 4, 1}}, ScalarType::uint8, Holes::none)),
                path.str());
  test::rewrite_decoded(path.str(), [](Metadata& m) { m.info.grid.dims[2] = 4; });
  const auto model = test::load<2>(path.str());
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("expected an axis with one sample for diamond2d"),
            std::string::npos)
      << model.error().message;
}

}  // namespace
}  // namespace lode::diamond
