// The parts of the container: header, directory, codecs, journals.
#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "lode/models/diamond/part_log.h"
#include "lode/store/block_index.h"
#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/directory.h"
#include "lode/store/header.h"
#include "lode/store/journal.h"
#include "lode/store/reader.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/fuzz_parts.h"

namespace lode::fuzz {
namespace {

using Bytes = std::vector<std::byte>;

/// A header whose checksum is right, as an attacker would make it.
void check_header(Input input) {
  std::array<std::byte, store::kHeaderBytes> start{};
  std::ranges::copy(input.first(std::min(input.size(), start.size())), start.begin());
  std::ranges::copy(std::as_bytes(std::span(store::kMagic)), start.begin());
  const auto content = std::span(start).first(start.size() - sizeof(std::uint64_t));
  const std::uint64_t sum = store::checksum(content);
  std::memcpy(start.data() + content.size(), &sum, sizeof(sum));
  std::uint64_t file_size = 0;
  std::memcpy(&file_size, start.data() + 24, sizeof(file_size));
  const auto header = store::decode_header(start, file_size, "file");
  if (header)
    expect(header->directory_offset >= store::kHeaderBytes &&
               header->directory_offset <= file_size &&
               header->directory_stored_size == file_size - header->directory_offset,
           "the directory is behind the blocks");
}

void check_blocks(const store::Directory& directory, std::uint64_t end) {
  std::uint64_t offset = store::kHeaderBytes;
  for (const store::BlockEntry& block : directory.blocks) {
    expect(block.offset == offset && block.raw_size <= store::kMaxBlockBytes, "blocks fit");
    offset += block.stored_size;
  }
  expect(offset == end, "blocks fill the file");
}

/// Records of which each begins with its length, in two bytes.
std::vector<Input> records_of(Input input) {
  std::vector<Input> records;
  while (input.size() > 2) {
    const auto parts = split(input);
    records.push_back(parts.first);
    input = parts.second;
  }
  return records;
}

/// A grid of at most n points.
store::ElementGrid grid_of(unsigned choice, std::size_t n) {
  constexpr std::size_t kMost = 65535;
  const std::size_t nx = std::min<std::size_t>(n, 1 + choice % 37);
  const std::size_t ny = nx == 0 ? 0 : std::min({n / nx, std::size_t{1 + choice % 5}, kMost});
  const std::size_t nz = ny == 0 ? 0 : std::min(n / (nx * ny), kMost);
  return {{static_cast<std::uint16_t>(nx), static_cast<std::uint16_t>(ny),
           static_cast<std::uint16_t>(nz)},
          choice % 2 == 1};
}

}  // namespace

/// First the header, then where the blocks end, then the directory as it is once decompressed.
void run_directory(Input input) {
  check_header(input);
  if (input.size() < sizeof(std::uint32_t)) return;
  std::uint32_t end = 0;
  std::memcpy(&end, input.data(), sizeof(end));
  const auto directory = store::decode_directory(
      input.subspan(sizeof(end)), {.path = "file", .blocks_end = end, .memory_limit = 1 << 24});
  if (!directory) return;
  check_blocks(*directory, end);
  const Bytes again = store::encode_directory(*directory);
  expect(std::ranges::equal(again, input.subspan(sizeof(end))), "a directory has one encoding");
}

/// Records that were to follow indexes' heads, each as a frame under a head that is right but where
/// its first byte says otherwise, and what it ends with as bytes between them.
void run_index(Input input) {
  Bytes file(store::kHeaderBytes);  // damaged, but for the magic
  std::ranges::copy(std::as_bytes(std::span(store::kMagic)), file.begin());
  for (const Input record : records_of(input)) {
    if (record.empty()) continue;
    const unsigned choice = std::to_integer<unsigned>(record[0]);
    Bytes index = store::encode_index(record.subspan(1), file.size() + choice / 8);
    if (choice % 2 == 1) index[16 + choice / 8] ^= std::byte{1};
    file.insert(file.end(), index.begin(), index.end());
    const Input between = record.last(record.size() / 4);
    file.insert(file.end(), between.begin(), between.end());
  }
  const std::string path = fuzz_directory().write("indexes.lode", file);
  const auto reader = store::Reader::open(path, {.length = store::Length::any});
  if (!reader) return;
  expect(reader->is_rebuilt(), "there is no directory");
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    const store::BlockEntry& block = reader->blocks()[i];
    expect(block.offset >= offset && block.raw_size <= store::kMaxBlockBytes, "blocks fit");
    expect(reader->find(block.key) == i, "keys differ");
    offset = block.offset + block.stored_size;
    if (offset <= file.size()) static_cast<void>(reader->read_block(i).has_value());
  }
}

/// A byte for the codec, one for the element size, three for the decoded size, and what is stored;
/// which also stands for what is to be encoded.
void run_codec(Input input) {
  constexpr std::size_t kHeadBytes = 5;
  if (input.size() < kHeadBytes) return;
  const unsigned choice = std::to_integer<unsigned>(input[0]);
  const auto codec = static_cast<store::Codec>(choice % (store::kLastCodec + 2U));
  const std::size_t element_size = std::to_integer<std::size_t>(input[1]) % 10;
  std::size_t raw_size = 0;
  for (std::size_t i = 0; i < 3; ++i)
    raw_size |= std::to_integer<std::size_t>(input[2 + i]) << (8 * i);
  const Input stored = input.subspan(kHeadBytes);
  Bytes raw(raw_size % (std::size_t{1} << 18));  // larger ones only take longer to clear
  static_cast<void>(store::decode_block(codec, element_size, stored, raw).has_value());
  if (!store::is_element_size(element_size) || static_cast<int>(codec) > store::kLastCodec) return;
  const store::ElementGrid grid = grid_of(choice, stored.size() / element_size);
  if (grid.n_elements() == 0) return;
  const Input elements = stored.first(grid.n_elements() * element_size);
  const store::EncodedBlock block = store::encode_block_as(codec, {elements, element_size, grid});
  Bytes decoded(elements.size());
  expect(store::decode_block(block.codec, element_size, block.stored, decoded).has_value() &&
             std::ranges::equal(decoded, elements),
         "what is encoded decodes to itself");
}

/// The file as it is; what it takes of it stays there when it is opened again.
void run_journal(Input input) {
  const std::string path = fuzz_directory().write("journal", input);
  const auto replay = [&](std::vector<Bytes>& records) {
    return store::Journal::reopen(path, [&](std::span<const std::byte> record) -> Result<bool> {
      records.emplace_back(record.begin(), record.end());
      return true;
    });
  };
  std::vector<Bytes> first;
  std::vector<Bytes> second;
  {
    auto journal = replay(first);
    expect(journal.has_value(), "a journal is cut where it is damaged");
    expect(journal->append(std::as_bytes(std::span("more"))).has_value(), "and goes on there");
  }
  expect(replay(second).has_value() && second.size() == first.size() + 1 &&
             std::equal(first.begin(), first.end(), second.begin()),
         "records stay");
}

/// Records that a build of a long field in parts might have left, whole and with right checksums.
void run_part_log(Input input) {
  const std::string output = fuzz_directory().path("out.lode");
  VolumeInfo info;
  info.grid.dims = {{600, 4, 4}};
  auto field = diamond::CoarseField<3>::make(info, true);
  const Bytes head(4, std::byte{1});
  fuzz_directory().write("out.lode.part", {});
  {
    auto journal = store::Journal::create(diamond::PartLog<3>::path_of(output));
    expect(journal && journal->append(head), "a journal can be made");
    for (const Input record : records_of(input))
      expect(journal->append(record).has_value(), "a journal takes any record");
  }
  diamond::PartsDone done;
  if (!diamond::PartLog<3>::resume(output, head, field, done)) return;
  const std::size_t n_chunks =
      diamond::n_points<3>(diamond::chunk_counts<3>(diamond::Shape<3>::of(field.shape.dims)));
  expect(done.n_chunks <= n_chunks, "no more chunks are done than there are");
  std::uint64_t offset = store::kHeaderBytes;
  for (const store::BlockEntry& block : done.blocks) {
    expect(block.offset == offset && block.raw_size <= store::kMaxBlockBytes &&
               block.stored_size <= block.raw_size,
           "blocks fit");
    offset += block.stored_size;
  }
}

}  // namespace lode::fuzz
