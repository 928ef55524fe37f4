#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/store/format.h"

namespace lode::store {

/// The first kHeaderBytes of a file, without what is constant.
struct Header {
  std::uint64_t features = 0;
  std::uint64_t file_size = 0;
  std::uint64_t directory_offset = 0;
  std::uint64_t directory_stored_size = 0;
  std::uint64_t directory_raw_size = 0;
  std::uint64_t directory_checksum = 0;

  friend constexpr bool operator==(const Header&, const Header&) = default;
};

[[nodiscard]] std::array<std::byte, kHeaderBytes> encode_header(const Header& header);

/// Whether `path` is a regular file that starts as .lode files do.
[[nodiscard]] bool starts_as_lode(const std::string& path);

/// Whether a file may be one that this program reads, though its header, all of which is in
/// `start`, may be damaged: it starts as .lode files do, and no whole header says another version
/// or unknown features.
[[nodiscard]] bool may_be_known(std::span<const std::byte> start);

/// The file's size as the first kHeaderBytes of it say, unchecked; the largest there is where they
/// are not all there.
[[nodiscard]] std::uint64_t said_size(std::span<const std::byte> start);

/// `start`: the first kHeaderBytes of the file, or all of it where it is shorter; file_size: its
/// real size. Fails, naming `path`, on anything this program cannot read; the extents in the
/// header that comes back lie inside the file and cover it to its end.
[[nodiscard]] Result<Header> decode_header(std::span<const std::byte> start,
                                           std::uint64_t file_size, const std::string& path);

}  // namespace lode::store
