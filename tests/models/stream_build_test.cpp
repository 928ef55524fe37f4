// Building a file part by part gives the bytes that building in memory gives, however it is parted.
#include "lode/models/diamond/stream_build.h"

#include "tests/models/stored_fixtures.h"

namespace lode::diamond {
namespace {

using store::TestPath;
using test::Holes;

/// Names the blocks that differ; then the bytes.
void expect_same_blocks(const std::string& path, const std::string& expected) {
  const auto a = store::Reader::open(path);
  const auto b = store::Reader::open(expected);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->blocks().size(), b->blocks().size());
  for (std::size_t i = 0; i < a->blocks().size(); ++i) {
    ASSERT_EQ(a->blocks()[i].key, b->blocks()[i].key) << i;
    const auto got = a->read_block(i);
    const auto wanted = b->read_block(i);
    ASSERT_TRUE(got && wanted);
    EXPECT_TRUE(*got == *wanted) << describe(a->blocks()[i].key);
  }
  EXPECT_TRUE(store::load_file(path) == store::load_file(expected));
}

template <int D>
void expect_same_file(const Volume& volume, const StreamSettings& settings) {
  const TestPath expected("memory.lode");
  const TestPath path("stream.lode");
  const Model<D> model = test::built<D>(volume);
  test::save<D>(model, expected.str());
  Progress progress;
  const auto source = make_memory_source(volume);
  const auto report = build_file<D>(*source, path.str(), settings, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->metadata.info, volume.info);
  EXPECT_EQ(report->metadata.summary, summarize<D>(model));
  expect_same_blocks(path.str(), expected.str());
}

struct BuildCase {
  Index3 dims;
  ScalarType type = ScalarType::uint8;
  Holes holes = Holes::none;

  friend void PrintTo(const BuildCase& c, std::ostream* out) {
    *out << fmt::format("{} x {} x {} {}{}", c.dims[0], c.dims[1], c.dims[2], name_of(c.type),
                        c.holes == Holes::some ? " with holes" : "");
  }
};

class stream_build : public ::testing::TestWithParam<BuildCase> {};

TEST_P(stream_build, gives_the_bytes_of_a_build_in_memory) {
  const Volume volume = test::random_samples(GetParam().dims, GetParam().type, GetParam().holes);
  const Index3& dims = GetParam().dims;
  const StreamSettings settings{.threads = {2}, .memory_limit = 0, .chunks_per_part = 1};
  if (std::min({dims[0], dims[1], dims[2]}) == 1)
    expect_same_file<2>(volume, settings);
  else
    expect_same_file<3>(volume, settings);
}

INSTANTIATE_TEST_SUITE_P(
    cases, stream_build,
    ::testing::Values(BuildCase{{{1, 1, 1}}}, BuildCase{{{2, 2, 2}}}, BuildCase{{{3, 2, 5}}},
                      BuildCase{{{9, 9, 9}}}, BuildCase{{{10, 9, 9}}},
                      BuildCase{{{17, 33, 20}}, ScalarType::float32},
                      BuildCase{{{65, 30, 41}}, ScalarType::int16, Holes::some},
                      BuildCase{{{5, 4, 3}}, ScalarType::float64, Holes::some},
                      BuildCase{{{257, 20, 18}}}, BuildCase{{{258, 20, 18}}},
                      BuildCase{{{20, 259, 18}}, ScalarType::uint16, Holes::some},
                      BuildCase{{{20, 18, 530}}, ScalarType::float32, Holes::some},
                      BuildCase{{{300, 280, 270}}},
                      BuildCase{{{40, 300, 270}}, ScalarType::float32},
                      BuildCase{{{2060, 70, 1}}, ScalarType::float32, Holes::some},
                      BuildCase{{{70, 1, 2100}}, ScalarType::uint8}));

}  // namespace
}  // namespace lode::diamond
