#include "tests/io/volume_test_files.h"

#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <fstream>

namespace lode::io::test {
namespace {

std::string deflated(const std::string& bytes, int window_bits) {
  z_stream stream{};
  EXPECT_EQ(
      deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY),
      Z_OK);
  std::string input = bytes;
  std::string out(deflateBound(&stream, static_cast<uLong>(input.size())) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

TempDir::TempDir() {
  std::string pattern = (std::filesystem::temp_directory_path() / "lode_io_test_XXXXXX").string();
  const char* made = ::mkdtemp(pattern.data());
  EXPECT_NE(made, nullptr);
  if (made != nullptr) path_ = made;
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TempDir::write(const std::string& name, const std::string& bytes) const {
  std::ofstream(path_ / name, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path(name);
}

std::string gzipped(const std::string& bytes) { return deflated(bytes, 15 + 16); }

std::string zlibbed(const std::string& bytes) { return deflated(bytes, 15); }

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

Result<Volume> read_volume(const std::string& path, const ReadOptions& options) {
  auto source = open_volume(path, options);
  if (!source) return source.error();
  return read_all(**source);
}

VolumeInfo info_of(const std::string& path, const ReadOptions& options) {
  const auto source = open_volume(path, options);
  if (source) return (*source)->info();
  ADD_FAILURE() << source.error().message;
  return {};
}

void expect_failure(const std::string& path, const std::vector<std::string>& parts,
                    const ReadOptions& options) {
  const auto volume = read_volume(path, options);
  ASSERT_FALSE(volume.has_value()) << path << " was read";
  const std::string& message = volume.error().message;
  EXPECT_NE(message.find(path), std::string::npos) << message;
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << part << " is not in: " << message;
}

NiftiBytes::NiftiBytes(const std::vector<std::int16_t>& dims, std::int16_t datatype,
                       ByteOrder order)
    : bytes_(352, '\0'), order_(order) {
  set<std::int32_t>(0, 348);
  set<std::int16_t>(40, static_cast<std::int16_t>(dims.size()));
  for (std::size_t i = 0; i < 7; ++i) {
    set<std::int16_t>(42 + 2 * i, i < dims.size() ? dims[i] : std::int16_t{1});
    set<float>(80 + 4 * i, 1);
  }
  set<float>(76, 1);
  set<std::int16_t>(70, datatype);
  set<float>(108, 352);
  set_text(344, "n+1");
}

NiftiBytes& NiftiBytes::set_sform(const std::vector<float>& rows) {
  set<std::int16_t>(254, 1);
  for (std::size_t i = 0; i < rows.size(); ++i) set<float>(280 + 4 * i, rows[i]);
  return *this;
}

std::string mutated(std::string bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t n_changes = 1 + below(4);
  for (std::size_t i = 0; i < n_changes && !bytes.empty(); ++i) {
    const std::size_t at = below(bytes.size());
    switch (below(6)) {
      case 0: bytes[at] = static_cast<char>(random()); break;
      case 1: bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8))); break;
      case 2: bytes.resize(at); break;
      case 3: bytes.erase(at, 1 + below(8)); break;
      case 4: bytes.insert(at, bytes.substr(at, 1 + below(16))); break;
      default: {
        // Counts are what hurts most: put a hostile one over a digit.
        constexpr const char* kNumbers[] = {"-1", "0", "4294967295", "9223372036854775807", "nan"};
        const std::size_t digit = bytes.find_first_of("0123456789", at);
        if (digit != std::string::npos) bytes.replace(digit, 1, kNumbers[below(5)]);
      }
    }
  }
  return bytes;
}

std::filesystem::path data_directory() {
  if (const char* directory = std::getenv("LODE_DATA")) return directory;
  return (std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data").lexically_normal();
}

}  // namespace lode::io::test
