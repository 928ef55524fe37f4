#include "tests/io/zarr_fixtures.h"

#include <zlib.h>

#include <fstream>
#include <sstream>

namespace lode::io::test {
namespace {

constexpr std::size_t kTarBlock = 512;

/// Blocks of a tar file, decompressed as they are asked for.
class TarBlocks {
 public:
  explicit TarBlocks(const char* path) : file_(gzopen(path, "rb")) { EXPECT_NE(file_, nullptr); }
  ~TarBlocks() { gzclose(file_); }
  TarBlocks(const TarBlocks&) = delete;
  TarBlocks& operator=(const TarBlocks&) = delete;

  /// `n` bytes and the rest of their last block; empty at the end of the file.
  std::string next(std::size_t n) {
    std::string bytes((n + kTarBlock - 1) / kTarBlock * kTarBlock, '\0');
    const int got = gzread(file_, bytes.data(), static_cast<unsigned>(bytes.size()));
    bytes.resize(got == static_cast<int>(bytes.size()) ? n : 0);
    return bytes;
  }

 private:
  gzFile file_;
};

std::string text_at(const std::string& header, std::size_t at, std::size_t size) {
  const std::string field = header.substr(at, size);
  return field.substr(0, field.find('\0'));
}

void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

ZarrFixture::ZarrFixture(const std::string& prefix) : prefix_(prefix) {
  TarBlocks tar(LODE_ZARR_FIXTURES);
  bool is_found = false;
  for (std::string header; !(header = tar.next(kTarBlock)).empty() && header[0] != '\0';) {
    constexpr std::size_t kSizeAt = 124, kTypeAt = 156, kPrefixAt = 345;
    const std::string folder = text_at(header, kPrefixAt, 155);
    const std::string name = (folder.empty() ? "" : folder + '/') + text_at(header, 0, 100);
    const std::string bytes = tar.next(std::stoul(text_at(header, kSizeAt, 12), nullptr, 8));
    if (!(name + '/').starts_with(prefix + '/')) continue;
    is_found = true;
    if (header[kTypeAt] == '5')
      std::filesystem::create_directories(dir_.path(name));
    else
      write_file(dir_.path(name), bytes);
  }
  EXPECT_TRUE(is_found) << prefix;
}

void ZarrFixture::write(const std::string& name, const std::string& bytes) const {
  write_file(path(name), bytes);
}

std::string ZarrFixture::read(const std::string& name) const {
  std::ostringstream bytes;
  bytes << std::ifstream(path(name), std::ios::binary).rdbuf();
  return bytes.str();
}

}  // namespace lode::io::test
