#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "tests/io/zarr_fixtures.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

using nlohmann::json;

/// A file of a fixture that is changed at random.
struct FuzzedFile {
  const char* fixture;
  const char* file;
};

/// Reads all of a small volume, and the corners of a large one: metadata may promise anything of
/// chunks that are missing.
Result<void> read_some(const std::string& path) {
  LODE_TRY(const auto source, open_volume(path, {.component = 0, .time = 0}));
  const VolumeInfo& info = source->info();
  constexpr std::int64_t kMaxSamples = 1 << 20;
  for (const bool is_end : {false, true}) {
    IndexBox box = info.grid.index_box();
    for (std::size_t i = 0; i < 3 && info.grid.n_samples() > kMaxSamples; ++i)
      (is_end ? box.lower : box.upper)[i] =
          is_end ? std::max(box.upper[i] - 8, 0) : std::min(box.upper[i], 8);
    std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) * size_of(info.type));
    LODE_CHECK(source->read(box, out));
  }
  return {};
}

/// The most memory this process ever held.
std::int64_t peak_kilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Runs `rounds` changes of one file; every failure names a file of the fixture.
template <typename F>
void fuzz(const FuzzedFile& fuzzed, int rounds, const F& change) {
  const test::ZarrFixture fixture(fuzzed.fixture);
  const auto unchanged = read_some(fixture.path());
  ASSERT_TRUE(unchanged) << unchanged.error().message;
  const std::string original = fixture.read(fuzzed.file);
  constexpr std::uint64_t kSeed = 20240921;
  SCOPED_TRACE(fmt::format("seed {}", kSeed));
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < rounds; ++round) {
    const std::string bytes = change(original, random);
    fixture.write(fuzzed.file, bytes);
    const auto status = read_some(fixture.path());
    if (status) continue;
    EXPECT_NE(status.error().message.find(fixture.path()), std::string::npos)
        << status.error().message;
  }
}

class zarr_fuzz : public testing::TestWithParam<FuzzedFile> {};

TEST_P(zarr_fuzz, survives_any_bytes) {
  fuzz(GetParam(), oracles::trials(600, 150),
       [](const std::string& original, std::mt19937_64& random) {
         return test::mutated(original, random);
       });
}

INSTANTIATE_TEST_SUITE_P(
    all, zarr_fuzz,
    testing::Values(FuzzedFile{"v2/fill_42", ".zarray"}, FuzzedFile{"v2/fill_42", "0.0.0"},
                    FuzzedFile{"v2/codec_blosc_lz4_bits", "0.0.0"},
                    FuzzedFile{"v2/codec_blosc_blosclz_none", "0.0.0"},
                    FuzzedFile{"v2/codec_blosc_zstd_bytes", "0.0.0"},
                    FuzzedFile{"v2/codec_blosc_snappy_none", "0.0.0"},
                    FuzzedFile{"v2/codec_zstd", "0.0.0"}, FuzzedFile{"v2/image", ".zattrs"},
                    FuzzedFile{"v3/shard_zstd", "zarr.json"},
                    FuzzedFile{"v3/shard_zstd", "c/0/0/0"},
                    FuzzedFile{"v3/shard_nested", "c/0/0/0"}, FuzzedFile{"v3/image", "zarr.json"}),
    [](const auto& each) {
      std::string name = fmt::format("{}_{}", each.param.fixture, each.param.file);
      for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      return name;
    });

/// Every value of the metadata replaced by every one that someone might get wrong.
class zarr_metadata_fuzz : public testing::TestWithParam<FuzzedFile> {};

TEST_P(zarr_metadata_fuzz, survives_any_value_anywhere_and_asks_for_little_memory) {
  const test::ZarrFixture fixture(GetParam().fixture);
  const json original = json::parse(fixture.read(GetParam().file));
  std::vector<std::string> pointers;
  const json flat = original.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    for (std::string at = pointer; !at.empty(); at.resize(at.rfind('/')))
      if (std::find(pointers.begin(), pointers.end(), at) == pointers.end()) pointers.push_back(at);
  }
  const std::int64_t before = peak_kilobytes();
  const std::vector<std::string> values{"-1",
                                        "0",
                                        "1",
                                        "2",
                                        "7",
                                        "255",
                                        "65536",
                                        "1048576",
                                        "2147483646",
                                        "2147483647",
                                        "4294967296",
                                        "9223372036854775807",
                                        "18446744073709551615",
                                        "-9223372036854775808",
                                        "1e308",
                                        "-0.5",
                                        "null",
                                        "true",
                                        "false",
                                        "\"\"",
                                        "\"x\"",
                                        "\"..\"",
                                        "\"zstd\"",
                                        "[]",
                                        "[0]",
                                        "[1, 1, 1]",
                                        "[1048576, 1048576, 1048576]",
                                        "[8, 8, 8]",
                                        "[[], [], []]",
                                        "{}",
                                        "{\"name\": \"bytes\"}",
                                        "{\"must_understand\": false}"};
  // Of the values each for some, in a fast run.
  const auto n_steps = oracles::trials<std::size_t>(1, 4);
  for (std::size_t i = 0; i < pointers.size(); ++i)
    for (std::size_t k = i % n_steps; k < values.size(); k += n_steps) {
      json changed = original;
      changed[json::json_pointer(pointers[i])] = json::parse(values[k]);
      fixture.write(GetParam().file, changed.dump());
      const auto status = read_some(fixture.path());
      if (!status)
        EXPECT_NE(status.error().message.find(fixture.path()), std::string::npos)
            << status.error().message;
    }
  // The samples of a million floats, twice, and what the process needs anyway.
  EXPECT_LT(peak_kilobytes() - before, 400 << 10);
}

INSTANTIATE_TEST_SUITE_P(
    all, zarr_metadata_fuzz,
    testing::Values(FuzzedFile{"v2/fill_42", ".zarray"}, FuzzedFile{"v2/image", ".zattrs"},
                    FuzzedFile{"v3/shard_transposed", "zarr.json"},
                    FuzzedFile{"v3/shard_nested", "zarr.json"}, FuzzedFile{"v3/image", "zarr.json"},
                    FuzzedFile{"v3/image", "s0/zarr.json"}),
    [](const auto& each) {
      std::string name = fmt::format("{}_{}", each.param.fixture, each.param.file);
      for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      return name;
    });

}  // namespace
}  // namespace lode::io
