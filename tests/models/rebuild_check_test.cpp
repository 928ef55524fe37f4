// Files held against what their own samples give, part by part.
#include "lode/models/diamond/rebuild_check.h"

#include <cstring>

#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/sample_check.h"
#include "tests/models/stored_fixtures.h"

namespace lode {
namespace {

using diamond::BlockFindings;
using diamond::ErrorCode;
using diamond::Kind;
using store::TestPath;

constexpr int kSmallMemory = 1;  // bytes: parts of one chunk, and no block is kept

template <int D>
Result<BlockFindings> check(const std::string& path, int n_threads, std::uint64_t memory_limit) {
  LODE_TRY(const auto reader, store::Reader::open(path));
  Progress progress;
  return diamond::rebuild_check<D>(reader, {.threads = {n_threads}, .memory_limit = memory_limit},
                                   progress);
}

template <int D>
void save_random(const TestPath& path, const Index3& dims, ScalarType type, test::Holes holes) {
  test::save<D>(test::built<D>(test::random_samples(dims, type, holes)), path.str());
}

std::uint64_t count_stored(const std::string& path, Kind kind, std::size_t size) {
  const auto reader = store::Reader::open(path);
  EXPECT_TRUE(reader);
  std::uint64_t n = 0;
  for (const store::BlockEntry& block : reader->blocks())
    if (block.key.kind == static_cast<std::uint32_t>(kind)) n += block.raw_size / size;
  return n;
}

template <int D>
void expect_true(const Index3& dims, ScalarType type, test::Holes holes) {
  SCOPED_TRACE(::testing::Message()
               << dims[0] << " " << dims[1] << " " << dims[2] << " " << name_of(type));
  const TestPath path("true.lode");
  save_random<D>(path, dims, type, holes);
  for (const int n_threads : {1, 3})
    for (const std::uint64_t limit : {std::uint64_t{0}, std::uint64_t{kSmallMemory}}) {
      const auto found = check<D>(path.str(), n_threads, limit);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->nodes.n_wrong, 0U) << found->nodes.worst;
      EXPECT_EQ(found->worlds.n_wrong, 0U) << found->worlds.worst;
      EXPECT_EQ(found->nodes.n_checked, count_stored(path.str(), Kind::errors, sizeof(ErrorCode)));
      EXPECT_EQ(found->worlds.n_checked,
                count_stored(path.str(), Kind::worlds, sizeof(diamond::WorldCode)));
    }
}

TEST(rebuild_check, finds_that_files_are_true) {
  expect_true<3>({{530, 11, 9}}, ScalarType::uint8, test::Holes::none);
  expect_true<3>({{19, 12, 520}}, ScalarType::int16, test::Holes::some);  // parts take over
  expect_true<3>({{270, 265, 5}}, ScalarType::float32, test::Holes::some);
  expect_true<3>({{8, 515, 7}}, ScalarType::float64, test::Holes::some);
  expect_true<3>({{2, 2, 2}}, ScalarType::uint16, test::Holes::none);
  expect_true<3>({{257, 3, 258}}, ScalarType::uint32, test::Holes::none);
  expect_true<2>({{2100, 30, 1}}, ScalarType::float32, test::Holes::some);
  expect_true<2>({{1, 40, 4200}}, ScalarType::uint8, test::Holes::none);
  expect_true<2>({{3, 1, 2}}, ScalarType::float64, test::Holes::none);
  expect_true<2>({{1, 1, 1}}, ScalarType::uint8, test::Holes::none);
}

/// Of the blocks of a kind the one with this number, changed; where it is.
store::BlockKey change(const std::string& path, Kind kind, std::size_t number,
                       const std::function<void(test::Bytes&)>& edit) {
  store::BlockKey changed{};
  std::size_t n = 0;
  test::rewrite(path, {}, [&](const store::BlockKey& key, test::Bytes& bytes) {
    if (key.kind != static_cast<std::uint32_t>(kind) || n++ != number) return;
    changed = key;
    edit(bytes);
  });
  return changed;
}

/// What is found where one number in the middle of one block is one less.
template <typename T>
void expect_found(Kind kind) {
  const TestPath path("lying.lode");
  save_random<3>(path, {{270, 12, 262}}, ScalarType::uint8, test::Holes::none);
  const std::vector<std::byte> original = store::load_file(path.str());
  const auto n_blocks = [&] {
    const auto reader = store::Reader::open(path.str());
    std::size_t n = 0;
    for (const store::BlockEntry& block : reader->blocks())
      n += block.key.kind == static_cast<std::uint32_t>(kind) ? 1 : 0;
    return n;
  }();
  ASSERT_GT(n_blocks, 10U);
  for (std::size_t number = 0; number < n_blocks; number += 3) {
    store::save_file(path.str(), original);
    const store::BlockKey key = change(path.str(), kind, number, [](test::Bytes& bytes) {
      std::byte* const at = bytes.data() + bytes.size() / sizeof(T) / 2 * sizeof(T);
      T value;
      std::memcpy(&value, at, sizeof(T));
      --value;
      std::memcpy(at, &value, sizeof(T));
    });
    SCOPED_TRACE(describe(key));
    const auto found = check<3>(path.str(), 2, kSmallMemory);
    ASSERT_TRUE(found) << found.error().message;
    const bool is_world = kind == Kind::worlds;
    const diamond::AttributeFinding& wrong = is_world ? found->worlds : found->nodes;
    EXPECT_EQ(wrong.n_wrong, 1U) << wrong.worst;
    EXPECT_NE(wrong.worst.find(fmt::format("level {}, node ", key.level)), std::string::npos)
        << wrong.worst;
    EXPECT_EQ((is_world ? found->nodes : found->worlds).n_wrong, 0U);
  }
}

TEST(rebuild_check, finds_single_errors) { expect_found<ErrorCode>(Kind::errors); }
TEST(rebuild_check, finds_single_lows) { expect_found<std::uint8_t>(Kind::lows); }
TEST(rebuild_check, finds_single_highs) { expect_found<std::uint8_t>(Kind::highs); }
TEST(rebuild_check, finds_single_world_errors) { expect_found<diamond::WorldCode>(Kind::worlds); }

TEST(rebuild_check, finds_errors_of_other_samples) {
  const TestPath path("other.lode");
  save_random<3>(path, {{270, 12, 262}}, ScalarType::uint8, test::Holes::none);
  const std::vector<std::byte> original = store::load_file(path.str());
  for (const std::uint32_t level : {0U, 1U}) {
    store::save_file(path.str(), original);
    test::rewrite(path.str(), {}, [&](const store::BlockKey& key, test::Bytes& bytes) {
      if (key.kind != static_cast<std::uint32_t>(Kind::samples) || key.level != level) return;
      if (key.position[0] != 1 || key.position[2] != 1) return;
      std::fill_n(bytes.begin(), 150, std::byte{50});  // none that is the nearest to a point beyond
    });
    const auto found = check<3>(path.str(), 2, kSmallMemory);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_GT(found->nodes.n_wrong, 0U);
  }
}

template <int D>
void expect_refused(const TestPath& path, const std::string& message) {
  const auto found = check<D>(path.str(), 2, kSmallMemory);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find(message), std::string::npos) << found.error().message;
  EXPECT_NE(found.error().message.find(path.str()), std::string::npos) << found.error().message;
}

TEST(rebuild_check, refuses_metadata_that_are_not_the_samples) {
  const TestPath path("metadata.lode");
  save_random<3>(path, {{270, 12, 262}}, ScalarType::int16, test::Holes::some);
  const std::vector<std::byte> original = store::load_file(path.str());
  const auto expect = [&](const std::function<void(diamond::Summary&)>& edit,
                          const std::string& message) {
    SCOPED_TRACE(message);
    store::save_file(path.str(), original);
    test::rewrite_decoded(path.str(), [&](diamond::Metadata& metadata) { edit(metadata.summary); });
    expect_refused<3>(path, message);
  };
  expect([](diamond::Summary& summary) { ++summary.stats.n_holes; }, "number of holes: expected");
  expect(
      [](diamond::Summary& summary) { summary.stats.n_holes = summary.stats.n_removed_cells = 0; },
      "expected no holes");
  expect([](diamond::Summary& summary) { --summary.stats.n_removed_cells; },
         "number of removed cells: expected");
  expect([](diamond::Summary& summary) { --summary.stats.min; }, "smallest sample: expected");
  expect([](diamond::Summary& summary) { ++summary.stats.max; }, "largest sample: expected");
  expect([](diamond::Summary& summary) { summary.base_error = 1e30; }, "base error: expected");
  expect([](diamond::Summary& summary) { summary.max_errors[4] = 1; },
         "largest error of level 4: expected");
}

TEST(rebuild_check, refuses_samples_beyond_the_data_that_are_not_the_nearest) {
  const TestPath path("beyond.lode");
  save_random<3>(path, {{270, 12, 262}}, ScalarType::uint8, test::Holes::none);
  const std::vector<std::byte> original = store::load_file(path.str());
  for (const std::uint32_t level : {2U, 4U}) {
    store::save_file(path.str(), original);
    bool is_changed = false;
    test::rewrite(path.str(), {}, [&](const store::BlockKey& key, test::Bytes& bytes) {
      if (key.kind != static_cast<std::uint32_t>(Kind::samples) || key.level != level) return;
      // The last one of the last block: a corner of the lattice.
      if (key.position[0] != (level == 2 ? 1 : 0) || key.position[2] != key.position[0]) return;
      bytes.back() = bytes.back() == std::byte{50} ? std::byte{51} : std::byte{50};
      is_changed = true;
    });
    ASSERT_TRUE(is_changed);
    expect_refused<3>(path, "beyond the data at grid point");
  }
}

TEST(rebuild_check, refuses_blocks_that_are_missing_and_others) {
  const TestPath path("blocks.lode");
  save_random<3>(path, {{30, 20, 28}}, ScalarType::uint8, test::Holes::none);
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  const auto write = [&](std::uint32_t left_out, bool with_another, std::uint32_t kind = 0) {
    auto writer = store::Writer::create(path.str(), reader->model(), reader->metadata());
    ASSERT_TRUE(writer);
    for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
      const store::BlockEntry& entry = reader->blocks()[i];
      if (store::is_index(entry.key)) continue;
      const test::Bytes raw = reader->read_block(i).value();
      if (entry.key.kind != left_out)
        ASSERT_TRUE(writer->append(entry.key, store::encode_block({raw, entry.element_size})));
      store::BlockKey other = entry.key;
      other.position[1] = 9;
      if (entry.key.kind == static_cast<std::uint32_t>(Kind::lows) && with_another)
        ASSERT_TRUE(writer->append(other, store::encode_block({raw, entry.element_size})));
    }
    if (kind > 0)
      ASSERT_TRUE(writer->append({kind, 0, {}}, store::encode_block({test::Bytes(16), 4})));
    ASSERT_TRUE(writer->finish());
  };
  constexpr std::uint32_t kOther = 77;  // readers may ignore what they do not know
  write(99, false, kOther);
  EXPECT_TRUE(check<3>(path.str(), 2, kSmallMemory));
  write(static_cast<std::uint32_t>(Kind::worlds), false);  // as in files from before there were any
  const auto found = check<3>(path.str(), 2, kSmallMemory);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->worlds.n_checked, 0U);
  write(static_cast<std::uint32_t>(Kind::highs), false);
  expect_refused<3>(path, "but the file has none");
  write(99, true);
  expect_refused<3>(path, "blocks, as its field has, got");
}

template <int D>
void expect_same_samples(const Index3& dims, ScalarType type, test::Holes holes) {
  SCOPED_TRACE(::testing::Message()
               << dims[0] << " " << dims[1] << " " << dims[2] << " " << name_of(type));
  const TestPath path("samples.lode");
  Volume volume = test::random_samples(dims, type, holes);
  test::save<D>(test::built<D>(volume), path.str());
  const auto compare = [&] {
    const auto reader = store::Reader::open(path.str());
    const auto source = make_memory_source(volume);
    Progress progress;
    return diamond::compare_samples<D>(*reader, *source,
                                       {.threads = {2}, .memory_limit = kSmallMemory}, progress);
  };
  const auto same = compare();
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(same->n_checked, static_cast<std::uint64_t>(volume.info.grid.n_samples()));
  EXPECT_EQ(same->n_wrong, 0U) << same->worst;
  const std::int64_t at = volume.info.grid.n_samples() * 3 / 4;
  volume.samples[static_cast<std::size_t>(at) * size_of(type)] ^= std::byte{2};
  const auto other = compare();
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_EQ(other->n_wrong, 1U);
  const std::string place = fmt::format("at sample {} {} {}", at % dims[0], at / dims[0] % dims[1],
                                        at / dims[0] / dims[1]);
  EXPECT_NE(other->worst.find(place), std::string::npos) << other->worst << " " << place;
}

TEST(rebuild_check, compares_samples_with_those_of_the_original) {
  expect_same_samples<3>({{270, 12, 262}}, ScalarType::uint8, test::Holes::none);
  expect_same_samples<3>({{9, 300, 5}}, ScalarType::float64, test::Holes::none);
  expect_same_samples<3>({{20, 21, 22}}, ScalarType::int16, test::Holes::some);
  expect_same_samples<2>({{1, 2100, 12}}, ScalarType::uint16, test::Holes::none);
  expect_same_samples<2>({{50, 1, 70}}, ScalarType::int32, test::Holes::none);
}

TEST(rebuild_check, ends_when_cancelled) {
  const TestPath path("cancelled.lode");
  save_random<3>(path, {{270, 12, 262}}, ScalarType::uint8, test::Holes::none);
  const auto reader = store::Reader::open(path.str());
  ASSERT_TRUE(reader);
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(diamond::rebuild_check<3>(*reader, {.threads = {2}}, progress));
}

}  // namespace
}  // namespace lode
