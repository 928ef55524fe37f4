#include "lode/models/diamond/part_log.h"

#include <filesystem>
#include <new>

#include "lode/store/bytes.h"

namespace lode::diamond {
namespace {

/// The nodes of a level that cells of a box of samples belong to: the points of its cubes.
template <int D>
LatticeBox<D> share_of(const Shape<D>& shape, int level, const LatticeBox<D>& samples) {
  const Index<D> dims = shape.grid_dims(level);
  LatticeBox<D> box;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    box.lower[i] = (samples.lower[i] >> (level + 1)) * 2;
    const std::int32_t last = std::min(samples.upper[i], shape.dims[i] - 1);
    const std::int32_t cubes = ((last - 1) >> (level + 1)) + 1;
    box.upper[i] = std::clamp(2 * cubes + 1, box.lower[i] + 1, dims[i]);
  }
  return box;
}

template <int D, typename Body>
void for_each_place(const Index<D>& dims, const LatticeBox<D>& box, const Body& body) {
  const Index<D> edges = box.upper - box.lower;
  for (std::size_t i = 0; i < n_points<D>(edges); ++i)
    body(linear_index<D>(dims, box.lower + point_of<D>(edges, i)));
}

template <int D>
void write_shares(const CoarseField<D>& field, const LatticeBox<D>& samples,
                  store::ByteWriter& out) {
  for (int level = kKeptLevel; level < field.shape.n_levels; ++level) {
    const NodeLevel& nodes = field.levels[as_size(level)];
    const LatticeBox<D> box = share_of<D>(field.shape, level, samples);
    const Index<D> dims = field.shape.grid_dims(level);
    for (const std::int32_t x : box.lower.v) out.write(x);
    for (const std::int32_t x : box.upper.v) out.write(x);
    for_each_place<D>(dims, box, [&](std::size_t at) { out.write(nodes.error[at]); });
    for_each_place<D>(dims, box, [&](std::size_t at) { out.write(nodes.low[at]); });
    for_each_place<D>(dims, box, [&](std::size_t at) { out.write(nodes.high[at]); });
    if (level > kKeptLevel) continue;  // those have no world errors yet
    const UninitializedArray<WorldCode>& worlds = field.worlds[as_size(level)];
    for_each_place<D>(dims, box, [&](std::size_t at) { out.write(field.finest_own[at]); });
    for_each_place<D>(dims, box, [&](std::size_t at) { out.write(worlds[at]); });
  }
}

/// What level kKeptLevel has beside its attributes.
template <int D>
Result<void> read_finest(store::ByteReader& in, const LatticeBox<D>& box, CoarseField<D>& field) {
  const std::size_t n = n_points<D>(box.upper - box.lower);
  LODE_TRY(const auto own, in.read_all<ErrorCode>(n));
  LODE_TRY(const auto worlds, in.read_all<WorldCode>(n));
  UninitializedArray<WorldCode>& to = field.worlds[as_size(kKeptLevel)];
  std::size_t i = 0;
  for_each_place<D>(field.shape.grid_dims(kKeptLevel), box, [&](std::size_t at) {
    field.finest_own[at] = std::max(field.finest_own[at], own[i]);
    to[at] = std::max(to[at], worlds[i]);
    ++i;
  });
  return {};
}

template <int D>
Result<void> read_shares(store::ByteReader& in, const std::string& path, CoarseField<D>& field) {
  for (int level = kKeptLevel; level < field.shape.n_levels; ++level) {
    NodeLevel& nodes = field.levels[as_size(level)];
    const Index<D> dims = field.shape.grid_dims(level);
    LatticeBox<D> box;
    for (std::int32_t& x : box.lower.v) {
      LODE_TRY(x, in.read<std::int32_t>());
    }
    for (std::int32_t& x : box.upper.v) {
      LODE_TRY(x, in.read<std::int32_t>());
    }
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (box.lower[i] < 0 || box.lower[i] >= box.upper[i] || box.upper[i] > dims[i])
        return fail("{}: expected a box of level {}'s nodes", path, level);
    const std::size_t n = n_points<D>(box.upper - box.lower);
    LODE_TRY(const auto errors, in.read_all<ErrorCode>(n));
    LODE_TRY(const auto lows, in.read_all<float>(n));
    LODE_TRY(const auto highs, in.read_all<float>(n));
    std::size_t i = 0;
    for_each_place<D>(dims, box, [&](std::size_t at) {
      nodes.error[at] = std::max(nodes.error[at], errors[i]);
      nodes.low[at] = std::min(nodes.low[at], lows[i]);
      nodes.high[at] = std::max(nodes.high[at], highs[i]);
      ++i;
    });
    if (level == kKeptLevel) LODE_CHECK(read_finest<D>(in, box, field));
  }
  return {};
}

void write_block(const store::BlockEntry& block, store::ByteWriter& out) {
  out.write(block.key.kind);
  out.write(block.key.level);
  for (const std::int32_t x : block.key.position.v) out.write(x);
  out.write(block.stored_size);
  out.write(block.raw_size);
  out.write(block.checksum);
  out.write(static_cast<std::uint8_t>(block.codec));
  out.write(block.element_size);
}

/// `offset`: where it begins.
Result<store::BlockEntry> read_block(store::ByteReader& in, std::uint64_t offset) {
  store::BlockEntry block;
  LODE_TRY(block.key.kind, in.read<std::uint32_t>());
  LODE_TRY(block.key.level, in.read<std::uint32_t>());
  for (std::int32_t& x : block.key.position.v) {
    LODE_TRY(x, in.read<std::int32_t>());
  }
  block.offset = offset;
  LODE_TRY(block.stored_size, in.read<std::uint64_t>());
  LODE_TRY(block.raw_size, in.read<std::uint64_t>());
  LODE_TRY(block.checksum, in.read<std::uint64_t>());
  LODE_TRY(const auto codec, in.read<std::uint8_t>());
  block.codec = static_cast<store::Codec>(codec);
  LODE_TRY(block.element_size, in.read<std::uint8_t>());
  return block;
}

/// Whether a writer may have made it.
bool is_block(const store::BlockEntry& block) {
  return block.raw_size <= store::kMaxBlockBytes && block.stored_size <= block.raw_size &&
         static_cast<std::uint8_t>(block.codec) <= store::kLastCodec &&
         store::is_element_size(block.element_size);
}

template <int D>
Result<void> read_part(std::span<const std::byte> record, const std::string& path,
                       CoarseField<D>& field, PartsDone& done) {
  store::ByteReader in(record, path);
  const std::size_t n_all = n_points<D>(chunk_counts<D>(field.shape));
  LODE_TRY(const auto n_chunks, in.read<std::uint64_t>());
  LODE_TRY(const auto n_largest, in.read<std::uint64_t>());
  if (n_chunks <= done.n_chunks || n_chunks > n_all || n_largest > as_size(kChunkLevel + 1))
    return fail("{}: expected more than {} of {} chunks to be done, got {} with {} levels", path,
                done.n_chunks, n_all, n_chunks, n_largest);
  LODE_TRY(auto largest, in.read_all<ErrorCode>(n_largest));
  LODE_TRY(const auto n_blocks, in.read<std::uint64_t>());
  for (std::uint64_t i = 0; i < n_blocks; ++i) {
    const std::uint64_t offset = done.blocks.empty()
                                     ? store::kHeaderBytes
                                     : done.blocks.back().offset + done.blocks.back().stored_size;
    LODE_TRY(auto block, read_block(in, offset));
    if (!is_block(block))
      return fail("{}: expected {} as it is written, got another", path, describe(block.key));
    done.blocks.push_back(block);
  }
  LODE_CHECK(read_shares<D>(in, path, field));
  LODE_CHECK(in.expect_end());
  done.n_chunks = static_cast<std::size_t>(n_chunks);
  done.largest_errors = std::move(largest);
  return {};
}

}  // namespace

template <int D>
Result<PartLog<D>> PartLog<D>::create(const std::string& output, std::span<const std::byte> head) {
  LODE_TRY(auto journal, store::Journal::create(path_of(output)));
  LODE_CHECK(journal.append(head));
  return PartLog(std::move(journal), 0);
}

template <int D>
Result<PartLog<D>> PartLog<D>::resume(const std::string& output, std::span<const std::byte> head,
                                      CoarseField<D>& field, PartsDone& done) {
  const std::string path = path_of(output);
  std::error_code status;
  if (!std::filesystem::exists(AtomicFile::part_path(output), status)) return create(output, head);
  bool has_head = false;
  LODE_TRY(auto journal,
           store::Journal::reopen(path, [&](std::span<const std::byte> record) -> Result<bool> {
             if (has_head) {
               LODE_CHECK(read_part<D>(record, path, field, done));
               return true;
             }
             has_head = true;
             if (std::ranges::equal(record, head)) return true;
             return fail(
                 "{}: it was begun from other samples, or by another version; build "
                 "without --resume to begin again",
                 AtomicFile::part_path(output));
           }));
  if (!has_head) LODE_CHECK(journal.append(head));
  return PartLog(std::move(journal), done.blocks.size());
}

template <int D>
Result<void> PartLog<D>::add(const PartPlan<D>& plan, const CoarseField<D>& field,
                             const PartsDone& done) {
  store::ByteWriter out;
  out.write(static_cast<std::uint64_t>(done.n_chunks));
  out.write(static_cast<std::uint64_t>(done.largest_errors.size()));
  out.write_all(std::span<const ErrorCode>(done.largest_errors));
  out.write(static_cast<std::uint64_t>(done.blocks.size() - n_blocks_));
  for (; n_blocks_ < done.blocks.size(); ++n_blocks_) write_block(done.blocks[n_blocks_], out);
  write_shares<D>(field, samples_of_chunks<D>(field.shape, plan.chunks), out);
  return journal_.append(out.bytes());
}

template <int D>
void PartLog<D>::remove_leftovers(const std::string& output) try {
  AtomicFile::remove_part(output);
  std::error_code status;
  if (!std::filesystem::exists(path_of(output), status)) return;
  if (auto journal = store::Journal::create(path_of(output))) journal->remove();
} catch (const std::bad_alloc&) {
  // The output is in its place: what earlier builds have left is in nobody's way.
}

template class PartLog<2>;
template class PartLog<3>;

}  // namespace lode::diamond
