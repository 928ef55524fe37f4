#include "lode/store/header.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "lode/store/bytes.h"
#include "lode/store/checksum.h"

namespace lode::store {
namespace {

constexpr std::size_t kVersionOffset = 8;
constexpr std::size_t kFeaturesOffset = 16;
constexpr std::size_t kSizeOffset = 24;
constexpr std::size_t kChecksumOffset = kHeaderBytes - sizeof(std::uint64_t);

template <typename T>
T load(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::string in_hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte b : bytes)
    text += fmt::format("{}{:02x}", text.empty() ? "" : " ", static_cast<unsigned>(b));
  return text;
}

Result<void> check_magic(std::span<const std::byte> start, const std::string& path) {
  if (start.empty()) return fail("{}: expected a .lode file, got an empty file", path);
  const auto magic = std::as_bytes(std::span(kMagic));
  const auto got = start.first(std::min(start.size(), kMagicBytes));
  if (std::ranges::equal(got, magic.first(got.size()))) return {};
  constexpr std::size_t kNameEnd = 4;
  if (got.size() >= kNameEnd && std::ranges::equal(got.subspan(1, 3), magic.subspan(1, 3)))
    return fail(
        "{}: expected a .lode file to start with {}, got {}: the file was damaged, perhaps by a "
        "transfer in text mode",
        path, in_hex(magic), in_hex(got));
  return fail("{}: not a .lode file: expected it to start with {}, got {}", path, in_hex(magic),
              in_hex(got));
}

Result<void> check_extents(const Header& header, std::uint64_t file_size, const std::string& path) {
  if (header.file_size != file_size)
    return fail("{}: expected {} bytes, as its header says, got {}: the file {}", path,
                header.file_size, file_size,
                file_size < header.file_size ? "is truncated" : "has bytes after its end");
  if (header.directory_offset < kHeaderBytes || header.directory_offset > file_size ||
      header.directory_stored_size != file_size - header.directory_offset)
    return fail(
        "{}: expected the directory between the header and the end of the file ({} bytes), got "
        "{} bytes at offset {}",
        path, file_size, header.directory_stored_size, header.directory_offset);
  return {};
}

}  // namespace

std::array<std::byte, kHeaderBytes> encode_header(const Header& header) {
  ByteWriter out;
  out.write_bytes(std::as_bytes(std::span(kMagic)));
  out.write(kFormatVersion);
  out.write(static_cast<std::uint32_t>(kHeaderBytes));
  out.write(header.features);
  out.write(header.file_size);
  out.write(header.directory_offset);
  out.write(header.directory_stored_size);
  out.write(header.directory_raw_size);
  out.write(header.directory_checksum);
  std::array<std::byte, kHeaderBytes> bytes{};
  std::ranges::copy(out.bytes(), bytes.begin());
  const std::uint64_t sum = checksum(std::span(bytes).first(kChecksumOffset));
  std::memcpy(bytes.data() + kChecksumOffset, &sum, sizeof(sum));
  return bytes;
}

bool starts_as_lode(const std::string& path) {
  std::error_code status;
  // Only regular files: opening a pipe would wait for its other end.
  if (!std::filesystem::is_regular_file(path, status)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, kMagicBytes> start{};
  return file.read(start.data(), start.size()) &&
         std::memcmp(start.data(), kMagic.data(), start.size()) == 0;
}

std::uint64_t said_size(std::span<const std::byte> start) {
  return start.size() < kHeaderBytes ? UINT64_MAX : load<std::uint64_t>(start, kSizeOffset);
}

bool may_be_known(std::span<const std::byte> start) {
  if (start.size() < kHeaderBytes ||
      !std::ranges::equal(start.first(kMagicBytes), std::as_bytes(std::span(kMagic))))
    return false;
  const bool is_whole =
      load<std::uint64_t>(start, kChecksumOffset) == checksum(start.first(kChecksumOffset));
  return !is_whole || (load<std::uint32_t>(start, kVersionOffset) == kFormatVersion &&
                       (load<std::uint64_t>(start, kFeaturesOffset) & ~kKnownFeatures) == 0);
}

Result<Header> decode_header(std::span<const std::byte> start, std::uint64_t file_size,
                             const std::string& path) {
  LODE_CHECK(check_magic(start, path));
  if (start.size() < kHeaderBytes)
    return fail("{}: expected a header of {} bytes, got a file of {}: the file is truncated", path,
                kHeaderBytes, file_size);
  // The checksum comes before the version, so that a damaged version is not taken for a newer one.
  const auto sum = load<std::uint64_t>(start, kChecksumOffset);
  const std::uint64_t real_sum = checksum(start.first(kChecksumOffset));
  if (sum != real_sum)
    return fail("{}: header is damaged: expected checksum {:016x}, got {:016x}", path, sum,
                real_sum);
  const auto version = load<std::uint32_t>(start, kVersionOffset);
  if (version != kFormatVersion)
    return fail("{}: the file has format version {}, this program reads version {}{}", path,
                version, kFormatVersion,
                version > kFormatVersion ? ": update lode" : ": build the file again");
  const auto header_bytes = load<std::uint32_t>(start, 12);
  if (header_bytes != kHeaderBytes)
    return fail("{}: expected a header of {} bytes, got one of {}", path, kHeaderBytes,
                header_bytes);
  const Header header{.features = load<std::uint64_t>(start, kFeaturesOffset),
                      .file_size = load<std::uint64_t>(start, kSizeOffset),
                      .directory_offset = load<std::uint64_t>(start, 32),
                      .directory_stored_size = load<std::uint64_t>(start, 40),
                      .directory_raw_size = load<std::uint64_t>(start, 48),
                      .directory_checksum = load<std::uint64_t>(start, 56)};
  const std::uint64_t unknown = header.features & ~kKnownFeatures;
  if (unknown != 0)
    return fail("{}: made by a newer version: feature bits {:#x} unknown: update lode", path,
                unknown);
  LODE_CHECK(check_extents(header, file_size, path));
  return header;
}

}  // namespace lode::store
