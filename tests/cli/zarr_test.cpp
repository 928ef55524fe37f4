#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

constexpr int kSize = 17;
constexpr int kChunk = 8;

std::uint8_t ball(int x, int y, int z) {
  const int distance = (x - 8) * (x - 8) + (y - 8) * (y - 8) + (z - 8) * (z - 8);
  return static_cast<std::uint8_t>(std::max(0, 250 - distance));
}

/// The ball's samples of one chunk; beyond the array they are 7.
std::string chunk_at(int cx, int cy, int cz) {
  std::string bytes;
  for (int z = cz * kChunk; z < (cz + 1) * kChunk; ++z)
    for (int y = cy * kChunk; y < (cy + 1) * kChunk; ++y)
      for (int x = cx * kChunk; x < (cx + 1) * kChunk; ++x)
        bytes += static_cast<char>(std::max({x, y, z}) < kSize ? ball(x, y, z) : 7);
  return bytes;
}

/// An OME-Zarr image of the ball with a spacing of 1, 2, 0.5 and an origin.
void write_image(const std::string& path) {
  const std::string array = path + "/scale0";
  write_bytes(path + "/.zgroup", R"({"zarr_format": 2})");
  write_bytes(path + "/.zattrs",
              R"({"multiscales": [{"version": "0.4", "axes": [
                    {"name": "z", "type": "space"}, {"name": "y", "type": "space"},
                    {"name": "x", "type": "space"}], "datasets": [{"path": "scale0",
                  "coordinateTransformations": [{"type": "scale", "scale": [0.5, 2, 1]},
                    {"type": "translation", "translation": [-3, 5, 10]}]}]}]})");
  std::filesystem::create_directory(array);
  write_bytes(array + "/.zarray",
              R"({"zarr_format": 2, "shape": [17, 17, 17], "chunks": [8, 8, 8], "dtype": "|u1",
                  "compressor": null, "filters": null, "fill_value": 0, "order": "C"})");
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x)
        write_bytes(fmt::format("{}/{}.{}.{}", array, z, y, x), chunk_at(x, y, z));
}

void write_same_nrrd(const std::string& path) {
  std::string bytes =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 17 17 17\nspace dimension: 3\n"
      "space directions: (1,0,0) (0,2,0) (0,0,0.5)\nspace origin: (10,5,-3)\nencoding: raw\n\n";
  for (int z = 0; z < kSize; ++z)
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) bytes += static_cast<char>(ball(x, y, z));
  write_bytes(path, bytes);
}

class cli_zarr : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(image());
    write_image(image());
    write_same_nrrd(scratch_ / "ball.nrrd");
  }
  [[nodiscard]] std::string image() const { return scratch_ / "ball.zarr"; }

  Scratch scratch_;
};

TEST_F(cli_zarr, builds_the_same_bytes_as_from_the_same_samples_in_nrrd) {
  for (const char* threads : {"1", "3"}) {
    const Finished zarr =
        run_lode({"build", image(), scratch_ / "zarr.lode", "--threads", threads});
    ASSERT_EQ(zarr.exit_code, 0) << zarr.err;
    const Finished nrrd =
        run_lode({"build", scratch_ / "ball.nrrd", scratch_ / "nrrd.lode", "--threads", threads});
    ASSERT_EQ(nrrd.exit_code, 0) << nrrd.err;
    EXPECT_EQ(read_bytes(scratch_ / "zarr.lode"), read_bytes(scratch_ / "nrrd.lode"));
  }
  const Finished verified =
      run_lode({"verify", scratch_ / "nrrd.lode", "--against", image(), "--quiet"});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
}

constexpr int kLargeSize = 640;
constexpr int kLargeWidth = 8;

/// Samples of few bytes once they are compressed.
std::string large_chunk(int chunk, int cy, int cz) {
  std::string bytes;
  for (int z = cz * chunk; z < (cz + 1) * chunk; ++z)
    for (int y = cy * chunk; y < (cy + 1) * chunk; ++y)
      for (int x = 0; x < kLargeWidth; ++x)
        bytes += static_cast<char>((x + y * y / 64 + z * z / 64) / 16);
  return bytes;
}

/// An array of nine parts, three each along y and z, in chunks of the array's width.
void write_large_array(const std::string& path, int chunk) {
  std::filesystem::create_directory(path);
  write_bytes(
      path + "/.zarray",
      fmt::format(R"({{"zarr_format": 2, "shape": [{0}, {0}, {1}], "chunks": [{2}, {2}, {1}],
                  "dtype": "|u1", "compressor": null, "filters": null, "fill_value": 0,
                  "order": "C"}})",
                  kLargeSize, kLargeWidth, chunk));
  for (int z = 0; z * chunk < kLargeSize; ++z)
    for (int y = 0; y * chunk < kLargeSize; ++y)
      write_bytes(fmt::format("{}/{}.{}.0", path, z, y), large_chunk(chunk, y, z));
}

std::uint64_t bytes_in(const std::string& directory) {
  std::uint64_t n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) n += entry.file_size();
  return n;
}

TEST_F(cli_zarr, moves_few_bytes_in_several_parts_whatever_the_chunks) {
  std::string expected;
  for (const int chunk : oracles::trials<std::vector<int>>({64, 100, 128, 256}, {100, 256})) {
    const std::string path = scratch_ / fmt::format("{}.zarr", chunk);
    write_large_array(path, chunk);
    const Finished built = run_lode({"build", path, scratch_ / "large.lode", "--json", "--quiet"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    const nlohmann::json report = built.json();
    EXPECT_EQ(report.at("parts"), 9);
    const auto n_output = report.at("file_bytes").get<std::uint64_t>();
    const std::uint64_t n_journal = n_output / 50;
    const nlohmann::json& io = report.at("io");
    const auto n_moved = io.at("file_bytes_read").get<std::uint64_t>() +
                         io.at("spool_bytes_written").get<std::uint64_t>() +
                         io.at("spool_bytes_read").get<std::uint64_t>() + n_output + n_journal;
    const auto n_least = static_cast<double>(bytes_in(path) + n_output);
    EXPECT_LE(static_cast<double>(n_moved), 2.3 * n_least) << chunk;
    const std::string bytes = read_bytes(scratch_ / "large.lode");
    if (expected.empty()) expected = bytes;
    EXPECT_TRUE(bytes == expected) << chunk;
  }
}

TEST_F(cli_zarr, describes_an_image_and_an_array_inside_it) {
  const nlohmann::json info = run_lode({"info", image(), "--json"}).json();
  EXPECT_EQ(info.at("format"), "OME-Zarr 0.4, Zarr v2, raw");
  EXPECT_EQ(info.at("spacing"), (nlohmann::json{1, 2, 0.5}));
  EXPECT_EQ(info.at("origin"), (nlohmann::json{10, 5, -3}));
  EXPECT_EQ(info.at("range"), (nlohmann::json{58, 250}));
  const nlohmann::json array = run_lode({"info", image() + "/scale0/", "--json"}).json();
  EXPECT_EQ(array.at("format"), "Zarr v2, raw");
  EXPECT_EQ(array.at("spacing"), (nlohmann::json{1, 1, 1}));
  EXPECT_EQ(array.at("range"), (nlohmann::json{58, 250}));
}

TEST_F(cli_zarr, names_the_file_that_is_damaged) {
  write_bytes(image() + "/scale0/1.2.0", "few");
  expect_refusal(run_lode({"build", image(), scratch_ / "zarr.lode", "--quiet"}), 1,
                 {image() + "/scale0/1.2.0", "expected 512 bytes, got 3"});
  write_bytes(image() + "/.zattrs", "{");
  expect_refusal(run_lode({"info", image()}), 1, {image() + "/.zattrs", "expected JSON"});
}

}  // namespace
}  // namespace lode::test
