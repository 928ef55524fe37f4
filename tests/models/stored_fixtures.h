#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/oracles/random.h"
#include "tests/oracles/typed_samples.h"
#include "tests/store/test_file.h"

namespace lode::test {

enum class Holes { none, some };
/// Uniform noise: 10 to 109 as integers, three quarters of that in floating point. With holes,
/// about one sample in a hundred is one: NaN, or as integer the "no data" value 5.
inline Volume random_samples(const Index3& dims, ScalarType type, Holes holes) {
  RegularGrid grid;
  grid.dims = dims;
  Volume volume = oracles::empty_volume(grid, type);
  volume.info.field_name = "noise";
  oracles::Random random(17);
  visit_scalar_type(type, [&]<typename T>() {
    const bool is_float = std::is_floating_point_v<T>;
    for (T& v : oracles::typed_samples<T>(volume)) {
      v = static_cast<T>(10 + random.below(100));
      if (is_float) v = static_cast<T>(static_cast<double>(v) * 0.75);
      if (holes == Holes::some && random.below(100) == 0)
        v = is_float ? std::numeric_limits<T>::quiet_NaN() : T(5);
    }
    if (holes == Holes::some && !is_float) volume.info.nodata = 5;
  });
  return volume;
}

template <int D>
diamond::Model<D> built(const Volume& volume) {
  Progress progress;
  const auto source = make_memory_source(volume);
  auto model = diamond::build<D>(*source, {.threads = {2}}, progress);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return std::move(model).value();
}

template <int D>
void save(const diamond::Model<D>& model, const std::string& path) {
  Progress progress;
  const auto saved = diamond::save<D>(model, path, {2}, progress);
  ASSERT_TRUE(saved) << saved.error().message;
}

/// Writes a file again without its blocks of a kind, as older ones are without world errors.
inline void leave_out(const std::string& path, diamond::Kind kind) {
  const auto reader = store::Reader::open(path);
  ASSERT_TRUE(reader);
  auto writer = store::Writer::create(path, reader->model(), reader->metadata());
  ASSERT_TRUE(writer);
  std::size_t n_left_out = 0;
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    const store::BlockEntry& entry = reader->blocks()[i];
    if (store::is_index(entry.key)) continue;
    if (entry.key.kind == static_cast<std::uint32_t>(kind)) {
      ++n_left_out;
      continue;
    }
    const auto raw = reader->read_block(i);
    ASSERT_TRUE(raw);
    ASSERT_TRUE(writer->append(entry.key, store::encode_block({*raw, entry.element_size})));
  }
  ASSERT_TRUE(writer->finish());
  ASSERT_GT(n_left_out, 0U);
}

template <int D>
Result<diamond::Model<D>> load(const std::string& path) {
  LODE_TRY(const auto reader, store::Reader::open(path));
  Progress progress;
  return diamond::load<D>(reader, {2}, progress);
}

using Bytes = std::vector<std::byte>;

/// Writes a file again with other metadata and blocks, right checksums, and no indexes.
inline void rewrite(const std::string& path, const std::function<void(Bytes&)>& edit_metadata,
                    const std::function<void(const store::BlockKey&, Bytes&)>& edit_block = {}) {
  const auto reader = store::Reader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  Bytes metadata(reader->metadata().begin(), reader->metadata().end());
  if (edit_metadata) edit_metadata(metadata);
  auto writer = store::Writer::create(path, reader->model(), metadata);
  ASSERT_TRUE(writer);
  writer->require(store::kFeatureRemovedCells);
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    const store::BlockEntry& entry = reader->blocks()[i];
    if (store::is_index(entry.key)) continue;
    auto raw = reader->read_block(i);
    ASSERT_TRUE(raw);
    if (edit_block) edit_block(entry.key, *raw);
    ASSERT_TRUE(writer->append(entry.key, store::encode_block({*raw, entry.element_size})));
  }
  ASSERT_TRUE(writer->finish());
}

/// The same, with the metadata as they are once decoded.
inline void rewrite_decoded(const std::string& path,
                            const std::function<void(diamond::Metadata&)>& edit) {
  const auto reader = store::Reader::open(path);
  ASSERT_TRUE(reader);
  auto metadata = diamond::read_metadata(*reader);
  ASSERT_TRUE(metadata) << metadata.error().message;
  edit(*metadata);
  rewrite(path, [&](Bytes& bytes) { bytes = diamond::encode_metadata(*metadata); });
}

}  // namespace lode::test
