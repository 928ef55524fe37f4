#include <algorithm>
#include <atomic>

#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/read_region.h"
#include "lode/models/diamond/sample_blocks.h"

namespace lode::diamond {
namespace {

/// Loads one kind of block into arrays, in parallel; body(i, bytes) puts the points of region i.
template <int D, typename Body>
Result<void> load_blocks(const store::Reader& reader, std::span<const Region<D>> regions, Kind kind,
                         std::size_t element_size, Threads threads, Progress& progress,
                         const Body& body) {
  std::vector<Error> errors(regions.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    const auto bytes = read_region<D>(reader, regions[i], kind, element_size);
    if (!bytes) {
      errors[i] = bytes.error();
      return;
    }
    body(i, bytes->data());
    progress.report("loading", static_cast<double>(++n_done) / static_cast<double>(regions.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  for (const Error& error : errors)
    if (!error.message.empty()) return error;
  return {};
}

/// Loads the samples of the data, x fastest, into `all`; those beyond it are only checked.
template <typename T, int D>
Result<void> load_samples_as(const Shape<D>& shape, const store::Reader& reader, Threads threads,
                             Progress& progress, std::byte* all) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, Kind::samples);
  std::vector<std::vector<std::byte>> beyond(regions.size());
  const auto put_block = [&](std::size_t block, const std::byte* from) {
    beyond[block] = put_samples_of<T, D>(shape, regions[block], from, all);
  };
  LODE_CHECK(
      load_blocks<D>(reader, regions, Kind::samples, sizeof(T), threads, progress, put_block));
  for (std::size_t i = 0; i < regions.size(); ++i)
    LODE_CHECK((check_beyond<T, D>(reader, shape, regions[i], all, beyond[i])));
  return {};
}

template <int D>
Result<void> load_samples(Model<D>& model, const store::Reader& reader, Threads threads,
                          Progress& progress) {
  const Index<D> dims = model.shape.dims;
  UninitializedArray<std::byte> all(n_points<D>(dims) * model.sample_size());
  LODE_CHECK(visit_storage_type(model.storage, [&]<typename T>() {
    return load_samples_as<T, D>(model.shape, reader, threads, progress, all.data());
  }));
  put_samples<D>(model, {{}, dims}, all.data(), threads);
  finish_samples<D>(model, threads);
  return {};
}

/// Loads one attribute, stored as T, into the arrays that array_of(level) gives.
template <typename T, int D, typename ArrayOf>
Result<void> load_attribute(const Shape<D>& shape, const store::Reader& reader, Kind kind,
                            Threads threads, Progress& progress, const ArrayOf& array_of) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, kind);
  const auto put_block = [&](std::size_t block, const std::byte* from) {
    const Region<D>& r = regions[block];
    auto& to = array_of(r.level);
    for_each_value<T, D>(r, shape.grid_dims(r.level), from,
                         [&](std::size_t at, T value) { to[at] = value; });
  };
  return load_blocks<D>(reader, regions, kind, sizeof(T), threads, progress, put_block);
}

/// Those of level 0 are not stored.
template <int D>
Result<void> load_worlds(Model<D>& model, const store::Reader& reader, Threads threads,
                         Progress& progress) {
  if (!has_worlds(reader)) return {};
  model.worlds.resize(model.levels.size());
  for (int level = 1; level < model.shape.n_levels; ++level)
    model.worlds[as_size(level)].assign(n_points<D>(model.shape.grid_dims(level)), 0);
  return load_attribute<WorldCode>(
      model.shape, reader, Kind::worlds, threads,
      progress, [&](int level) -> auto& { return model.worlds[as_size(level)]; });
}

template <int D>
Result<void> load_attributes(Model<D>& model, const store::Reader& reader, Threads threads,
                             Progress& progress) {
  for (int level = 1; level < model.shape.n_levels; ++level) {
    NodeLevel& nodes = model.levels[as_size(level)];
    const std::size_t n = n_points<D>(model.shape.grid_dims(level));
    nodes.error.assign(n, 0);
    nodes.low.assign(n, std::numeric_limits<float>::infinity());
    nodes.high.assign(n, -std::numeric_limits<float>::infinity());
  }
  LODE_CHECK(load_worlds<D>(model, reader, threads, progress));
  const auto load_kind = [&]<typename T>(Kind kind, auto NodeLevel::*array) {
    return load_attribute<T>(
        model.shape, reader, kind, threads,
        progress, [&](int level) -> auto& { return model.levels[as_size(level)].*array; });
  };
  LODE_CHECK(load_kind.template operator()<ErrorCode>(Kind::errors, &NodeLevel::error));
  return visit_range_type(model.storage, [&]<typename R>() -> Result<void> {
    LODE_CHECK(load_kind.template operator()<R>(Kind::lows, &NodeLevel::low));
    LODE_CHECK(load_kind.template operator()<R>(Kind::highs, &NodeLevel::high));
    for (NodeLevel& nodes : model.levels) LODE_CHECK(check_nodes(nodes, reader, threads));
    return {};
  });
}

}  // namespace

template <int D>
Result<Model<D>> load(const store::Reader& reader, Threads threads, Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  LODE_CHECK(check_current(reader, metadata));
  Model<D> model = Model<D>::make(metadata.info);
  LODE_CHECK(load_samples<D>(model, reader, threads, progress));
  LODE_CHECK(check_stats(reader, metadata.summary.stats, model.stats));
  model.levels.resize(as_size(model.shape.n_levels));
  LODE_CHECK(load_attributes<D>(model, reader, threads, progress));
  compute_level_0<D>(model, threads);
  LODE_CHECK(check_errors(reader, metadata.summary, summarize<D>(model)));
  return model;
}

bool has_worlds(const store::Reader& reader) {
  return std::ranges::any_of(reader.blocks(), [](const store::BlockEntry& block) {
    return block.key.kind == static_cast<std::uint32_t>(Kind::worlds);
  });
}

StoredBytes stored_bytes(const store::Reader& reader) {
  StoredBytes bytes;
  for (const store::BlockEntry& block : reader.blocks()) {
    if (store::is_index(block.key) || block.key.level > 31) continue;
    if (bytes.by_level.size() <= block.key.level) bytes.by_level.resize(block.key.level + 1);
    bytes.by_level[block.key.level] += block.stored_size;
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples))
      bytes.samples += block.stored_size;
  }
  bytes.attributes = reader.file_size() - bytes.samples;
  return bytes;
}

template Result<Model<2>> load<2>(const store::Reader&, Threads, Progress&);
template Result<Model<3>> load<3>(const store::Reader&, Threads, Progress&);

}  // namespace lode::diamond
