#include "lode/io/layer_spool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <random>

#include "tests/io/unit_source.h"
#include "tests/oracles/synthetic_volumes.h"

namespace lode::io {
namespace {

using test::UnitSource;

std::vector<std::byte> samples_in(VolumeSource& source, const IndexBox& box) {
  std::vector<std::byte> out(static_cast<std::size_t>(box.n_samples()) *
                             size_of(source.info().type));
  EXPECT_TRUE(source.read(box, out));
  return out;
}

/// A source in units with little to keep them in, and what it decodes.
struct Wrapped {
  Wrapped(const Volume& volume, const Index3& unit, std::uint64_t held = 0) {
    auto owned = std::make_unique<UnitSource>(volume, unit);
    owned->hold(held);
    units = owned.get();
    auto made = LayerSpool::wrap(std::move(owned), testing::TempDir());
    EXPECT_TRUE(made) << (made ? "" : made.error().message);
    source = std::move(*made);
  }
  UnitSource* units = nullptr;
  std::unique_ptr<VolumeSource> source;
};

/// What can be known of a volume that is not there.
class ShapeSource final : public VolumeSource {
 public:
  explicit ShapeSource(VolumeInfo info) : info_(std::move(info)) {}
  [[nodiscard]] const VolumeInfo& info() const override { return info_; }
  [[nodiscard]] Result<void> read(const IndexBox& /*box*/, std::span<std::byte> /*out*/) override {
    return fail("nothing is there");
  }
  [[nodiscard]] ReadUnit read_unit() const override { return {.dims = {{2, 2, 2}}}; }

 private:
  VolumeInfo info_;
};

class layer_spool : public ::testing::TestWithParam<std::pair<Index3, Index3>> {};

TEST_P(layer_spool, gives_all_samples_and_decodes_each_unit_once) {
  const auto& [dims, unit] = GetParam();
  const Volume volume = oracles::noise(dims);
  const auto expected = make_memory_source(volume);
  const Wrapped wrapped(volume, unit);
  ASSERT_NE(wrapped.source.get(), wrapped.units);
  for (std::int32_t z = 0; z < dims[2]; z += 3) {  // slices in ascending order, as scans read
    const IndexBox slab{{{0, 0, z}}, {{dims[0], dims[1], std::min(z + 3, dims[2])}}};
    EXPECT_EQ(samples_in(*wrapped.source, slab), samples_in(*expected, slab));
  }
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    IndexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lower[axis] = static_cast<std::int32_t>(random()) & 0x7fff;
      box.lower[axis] %= dims[axis];
      box.upper[axis] =
          box.lower[axis] + 1 +
          (static_cast<std::int32_t>(random()) & 0x7fff) % (dims[axis] - box.lower[axis]);
    }
    EXPECT_EQ(samples_in(*wrapped.source, box), samples_in(*expected, box));
  }
  for (const auto& [place, n] : wrapped.units->take_counts()) EXPECT_EQ(n, 1);
  EXPECT_LE(wrapped.source->io().n_spool_bytes_written, volume.samples.size());
}

INSTANTIATE_TEST_SUITE_P(sizes, layer_spool,
                         ::testing::Values(std::pair{Index3{{50, 40, 30}}, Index3{{16, 16, 16}}},
                                           std::pair{Index3{{33, 7, 20}}, Index3{{8, 8, 8}}},
                                           std::pair{Index3{{9, 70, 5}}, Index3{{4, 32, 2}}},
                                           std::pair{Index3{{200, 1, 9}}, Index3{{64, 1, 4}}}));

TEST(layer_spool_wrap, leaves_sources_alone_that_decode_single_slices_or_all_at_once) {
  const Volume volume = oracles::noise({{20, 20, 20}});
  for (const Index3& unit : {Index3{{1, 1, 1}}, Index3{{8, 8, 1}}, Index3{{32, 20, 4}}}) {
    const Wrapped wrapped(volume, unit, 32'000);
    EXPECT_EQ(wrapped.source.get(), wrapped.units);
  }
}

TEST(layer_spool_wrap, decodes_units_once_that_the_source_cannot_hold) {
  const Volume volume = oracles::noise({{40, 20, 300}});
  auto owned = std::make_unique<UnitSource>(volume, Index3{{64, 32, 128}});
  UnitSource& units = *owned;
  units.hold(1000);
  auto made = LayerSpool::wrap(std::move(owned), testing::TempDir());
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_GE((*made)->memory_bytes(), 1000U + 40 * 20 * 128);
  for (std::int32_t z = 0; z < 300; ++z) (void)samples_in(**made, {{{0, 0, z}}, {{40, 20, z + 1}}});
  for (const auto& [place, n] : units.take_counts()) EXPECT_EQ(n, 1);
}

TEST(layer_spool_wrap, takes_no_memory_for_layers_that_are_not_read) {
  Volume volume = oracles::noise({{8, 8, 8}});
  volume.info.grid.dims = {{2'000'000'000, 2'000'000'000, 2'000'000'000}};
  // Its samples are not there, and are not asked for.
  auto made = LayerSpool::wrap(std::make_unique<ShapeSource>(volume.info), testing::TempDir());
  ASSERT_TRUE(made) << made.error().message;
}

TEST(layer_spool_wrap, ends_a_read_that_is_cancelled) {
  const Volume volume = oracles::noise({{64, 64, 64}});
  const Wrapped wrapped(volume, {{16, 16, 16}});
  Progress progress;
  wrapped.source->obey(&progress);
  progress.cancel();
  const IndexBox slice{{}, {{64, 64, 1}}};
  std::vector<std::byte> out(static_cast<std::size_t>(slice.n_samples()) *
                             size_of(volume.info.type));
  const auto status = wrapped.source->read(slice, out);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, cancelled_error().message);
  wrapped.source->obey(nullptr);
  EXPECT_TRUE(wrapped.source->read(slice, out));
}

TEST(layer_spool_wrap, reads_the_source_where_the_disk_is_full) {
  const Volume volume = oracles::noise({{64, 64, 64}});
  const Wrapped wrapped(volume, {{16, 16, 16}});
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{.rlim_cur = 100'000, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const IndexBox all{{}, volume.info.grid.dims};
  EXPECT_EQ(samples_in(*wrapped.source, all), volume.samples);
  EXPECT_EQ(samples_in(*wrapped.source, all), volume.samples);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
}

}  // namespace
}  // namespace lode::io
