// Building a file part by part gives the bytes that building in memory gives, however it is parted.
#include "lode/models/diamond/stream_build.h"

#include "lode/models/diamond/nesting_pass.h"
#include "lode/models/diamond/part_builder.h"
#include "tests/io/unit_source.h"
#include "tests/models/all_targets.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/trials.h"

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
  const auto plain = make_memory_source(volume);
  io::test::UnitSource in_units(volume, {{100, 90, 110}});  // border layers of which are spooled
  for (VolumeSource* source : {plain.get(), static_cast<VolumeSource*>(&in_units)}) {
    Progress progress;
    const auto report = build_file<D>(*source, path.str(), settings, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->metadata.info, volume.info);
    EXPECT_EQ(report->metadata.summary, summarize<D>(model));
    expect_same_blocks(path.str(), expected.str());
  }
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
                      BuildCase{oracles::trials<Index3>({{300, 280, 270}}, {{300, 280, 40}})},
                      BuildCase{oracles::trials<Index3>({{40, 300, 270}}, {{12, 300, 270}}),
                                ScalarType::float32},
                      BuildCase{{{20, 30, 1040}}, ScalarType::int8},
                      BuildCase{oracles::trials<Index3>({{260, 30, 1031}}, {{260, 12, 1031}})},
                      BuildCase{{{2060, 70, 1}}, ScalarType::float32, Holes::some},
                      BuildCase{{{70, 1, 2100}}, ScalarType::uint8}));

TEST(stream_build, gives_the_same_bytes_with_every_kind_of_vector) {
  for (const auto& [dims, type, holes] :
       {BuildCase{{{70, 45, 39}}}, BuildCase{{{131, 40, 35}}, ScalarType::int16},
        BuildCase{{{67, 41, 37}}, ScalarType::int16, Holes::some},
        BuildCase{{{66, 35, 34}}, ScalarType::float32}, BuildCase{{{35, 260, 40}}}}) {
    SCOPED_TRACE(dims[0]);
    const Volume volume = test::random_samples(dims, type, holes);
    const TestPath expected("expected.lode");
    test::save<3>(test::built<3>(volume), expected.str());
    test::for_each_target([&] {
      const TestPath path("target.lode");
      test::save<3>(test::built<3>(volume), path.str());
      expect_same_blocks(path.str(), expected.str());
    });
  }
}

/// The part's samples, x fastest.
std::vector<std::byte> samples_of(const Volume& volume, const LatticeBox<3>& box) {
  const auto source = make_memory_source(volume);
  const IndexBox part{box.lower, box.upper};
  std::vector<std::byte> bytes(static_cast<std::size_t>(part.n_samples()) *
                               size_of(volume.info.type));
  EXPECT_TRUE(source->read(part, bytes));
  return bytes;
}

TEST(stream_build_parts, of_two_workers_in_any_order_join_to_the_nodes_of_the_whole) {
  const Volume volume = test::random_samples({{300, 270, 530}}, ScalarType::uint8, Holes::none);
  const Model<3> model = test::built<3>(volume);
  // Each worker has the coarse samples and the stats, and its own shares of the nodes.
  std::array<CoarseField<3>, 2> fields{CoarseField<3>::make(volume.info, true),
                                       CoarseField<3>::make(volume.info, true)};
  std::vector<PartBuilder<3>> workers;
  for (CoarseField<3>& field : fields) {
    field.put_samples({{}, field.shape.dims}, volume.samples.data());
    field.stats = model.stats;
    workers.emplace_back(field, Threads{1});
  }
  const Index<3> n = chunk_counts<3>(model.shape);
  std::vector<std::size_t> order(n_points<3>(n));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = (i * 5 + 3) % order.size();
  ASSERT_EQ(order.size(), 12U);
  for (const std::size_t i : order) {
    const Index<3> chunk = point_of<3>(n, i);
    const auto plan = PartPlan<3>::of(model.shape, {chunk, chunk + all_equal<3>(1)});
    PartBuilder<3>& worker = workers[i % 3 == 0 ? 0 : 1];
    worker.begin(plan);
    worker.put_samples(plan.samples, samples_of(volume, plan.samples).data());
    ASSERT_TRUE(worker.find_attributes(Progress(), [] {}));
  }
  fields[0].join(fields[1]);
  NestingPass<3, CoarseField<3>>(fields[0], kKeptLevel, model.shape.n_levels, {1}).run();
  for (std::size_t level = kKeptLevel; level < model.levels.size(); ++level) {
    EXPECT_TRUE(fields[0].levels[level].error == model.levels[level].error) << level;
    EXPECT_TRUE(fields[0].levels[level].low == model.levels[level].low) << level;
    EXPECT_TRUE(fields[0].levels[level].high == model.levels[level].high) << level;
  }
}

}  // namespace
}  // namespace lode::diamond
