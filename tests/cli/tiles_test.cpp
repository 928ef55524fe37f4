// Tiles for globes, through the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "tests/cli/program.h"

namespace lode::test {
namespace {

/// 60 x 45 heights in degrees, ESRI ASCII, some missing; one of them `raised`.
void write_degrees(const std::string& path, int raised = 0) {
  std::ofstream file(path);
  file << "ncols 60\nnrows 45\nxllcorner 9.8\nyllcorner 44.9\ncellsize 0.01\nnodata_value -9999\n";
  for (int y = 0; y < 45; ++y)
    for (int x = 0; x < 60; ++x) {
      const long z = std::lround(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y));
      file << (x > 6 && x < 10 && y == 9 ? -9999
               : x == 31 && y == 22      ? z + raised
                                         : z)
           << (x + 1 < 60 ? ' ' : '\n');
    }
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::map<std::string, std::string> files_in(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[std::filesystem::relative(entry.path(), folder).string()] = content_of(entry.path());
  return files;
}

class cli_tiles : public testing::Test {
 protected:
  cli_tiles() { write_degrees(dem_); }

  Finished cut(std::vector<std::string> more = {}) {
    more.emplace_back("--json");
    return cut_in_words(more);
  }
  Finished cut_in_words(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"tiles", dem_, folder_, "--max-error", "5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_lode(arguments);
  }
  /// Of the check by this name.
  static bool passes(const Finished& verified, const std::string& name) {
    const auto json = nlohmann::json::parse(verified.out);
    for (const auto& check : json.at("checks"))
      if (check.at("name") == name) return check.at("passed");
    ADD_FAILURE() << name;
    return false;
  }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string folder_ = scratch_ / "tiles";
};

TEST_F(cli_tiles, are_what_layer_json_says) {
  const auto told = cut().json();
  const auto layer = nlohmann::json::parse(content_of(folder_ + "/layer.json"));
  EXPECT_EQ(layer.at("format"), "quantized-mesh-1.0");
  EXPECT_EQ(layer.at("maxzoom"), told.at("levels").size() - 1);
  std::size_t n_tiles = 0;
  std::size_t n_bytes = 0;
  for (std::size_t level = 0; level < told.at("levels").size(); ++level) {
    const auto& one = told.at("levels")[level];
    n_tiles += one.at("tiles").get<std::size_t>();
    n_bytes += one.at("bytes").get<std::size_t>();
    EXPECT_EQ(layer.at("errors")[level].at("achieved_error"), one.at("achieved_error"));
    EXPECT_LE(one.at("achieved_error"), one.at("max_error"));
    EXPECT_EQ(one.at("tiles_beyond"), 0);
    std::size_t n_available = 0;
    for (const auto& range : layer.at("available")[level]) {
      const auto size = [&](const char* from, const char* to) {
        return range.at(to).get<std::size_t>() - range.at(from).get<std::size_t>() + 1;
      };
      n_available += size("startX", "endX") * size("startY", "endY");
    }
    EXPECT_EQ(n_available, one.at("tiles"));
  }
  EXPECT_EQ(told.at("levels").back().at("max_error"), 5);
  EXPECT_EQ(told.at("missing_samples"), 3);
  auto files = files_in(folder_);
  EXPECT_EQ(files.size(), n_tiles + 1);
  for (const auto& [name, bytes] : files) n_bytes -= name == "layer.json" ? 0 : bytes.size();
  EXPECT_EQ(n_bytes, 0);
}

/// As the format's document has headers and heights: no code of Lode's.
struct TileHeader {
  std::array<double, 3> centre{};
  float lowest = 0;
  float highest = 0;
  std::array<double, 4> sphere{};
  std::uint16_t top = 0;  ///< The largest number of a height.

  explicit TileHeader(const std::string& bytes) {
    std::memcpy(centre.data(), &bytes[0], 24);
    std::memcpy(&lowest, &bytes[24], 4);
    std::memcpy(&highest, &bytes[28], 4);
    std::memcpy(sphere.data(), &bytes[32], 32);
    std::uint32_t n = 0;
    std::memcpy(&n, &bytes[88], 4);
    std::uint16_t number = 0;
    for (std::uint32_t v = 0; v < n; ++v) {
      std::uint16_t code = 0;
      std::memcpy(&code, &bytes[92 + 2 * (std::size_t{2} * n + v)], 2);
      number = static_cast<std::uint16_t>(number + ((code >> 1) ^ -(code & 1)));
      top = std::max(top, number);
    }
  }
};

/// Clients cull tiles, and choose levels, by what headers say.
TEST_F(cli_tiles, have_headers_near_their_heights) {
  ASSERT_EQ(cut().exit_code, 0);
  int n_seen = 0;
  for (const auto& [name, bytes] : files_in(folder_)) {
    if (name == "layer.json") continue;
    const TileHeader tile(bytes);
    const double range = (tile.highest - tile.lowest) * (tile.top / 32767.0);
    // Or as near as float32 has numbers: 24 bits, of which 15 are the tile's.
    const double least = 32767 * 2 * (std::abs(tile.lowest) / 16744449 + 0x1p-30);
    EXPECT_LE(tile.highest - tile.lowest, std::max(2 * range, least)) << name;
    const double off = std::hypot(tile.centre[0] - tile.sphere[0], tile.centre[1] - tile.sphere[1],
                                  tile.centre[2] - tile.sphere[2]);
    EXPECT_LE(off, tile.sphere[3]) << name;
    ++n_seen;
  }
  EXPECT_GT(n_seen, 10);
}

TEST_F(cli_tiles, are_verified_against_their_raster) {
  ASSERT_EQ(cut().exit_code, 0);
  const Finished alone = run_lode({"verify", folder_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  const Finished against = run_lode({"verify", folder_, "--against", dem_});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  write_degrees(dem_, 20);
  const Finished other = run_lode({"verify", folder_, "--against", dem_, "--json"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("error of level"), std::string::npos) << other.err;
}

TEST_F(cli_tiles, are_refused_when_damaged) {
  const auto told = cut().json();
  const std::string level = std::to_string(told.at("levels").size() - 1);
  std::vector<std::filesystem::path> tiles;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ + "/" + level))
    if (entry.is_regular_file()) tiles.push_back(entry.path());
  std::ranges::sort(tiles);
  const std::filesystem::path& tile = tiles[tiles.size() / 2];
  const std::string whole = content_of(tile);
  const auto rewrite = [&](const std::string& bytes) {
    std::ofstream(tile, std::ios::binary) << bytes;
  };
  // The lowest height, so that its sides are no longer its neighbours'.
  std::string raised = whole;
  const float lowest = 7;
  std::memcpy(&raised[24], &lowest, sizeof lowest);
  rewrite(raised);
  EXPECT_FALSE(passes(run_lode({"verify", folder_, "--json"}), "tiles of a level meet"));
  rewrite(whole.substr(0, 56) + std::string(8, '\0') + whole.substr(64));
  EXPECT_FALSE(passes(run_lode({"verify", folder_, "--json"}),
                      "spheres hold their tiles, and occlusion points are outside"));
  rewrite(whole.substr(0, whole.size() - 9));
  EXPECT_FALSE(passes(run_lode({"verify", folder_, "--json"}), "tiles are there and whole"));
  std::filesystem::remove(tile);
  const Finished missing = run_lode({"verify", folder_});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.err.find(tile.filename().string()), std::string::npos) << missing.err;
  for (
      const char* layer :
      {"", "[]", "{}", R"({"format":"quantized-mesh-1.0","scheme":"tms"})",
       R"({"format":"quantized-mesh-1.0","scheme":"tms","available":[[{"startX":0,"endX":9}]]})"}) {
    std::ofstream(folder_ + "/layer.json") << layer;
    const Finished bad = run_lode({"verify", folder_});
    EXPECT_EQ(bad.exit_code, 1);
    EXPECT_NE(bad.err.find("layer.json: "), std::string::npos) << bad.err;
  }
}

TEST_F(cli_tiles, have_to_cover_their_raster_to_be_verified) {
  const auto told = cut().json();
  const std::size_t last = told.at("levels").size() - 1;
  const std::string layer_path = folder_ + "/layer.json";
  const auto layer = nlohmann::json::parse(content_of(layer_path));
  const auto verify = [&](const nlohmann::json& changed) {
    std::ofstream(layer_path) << changed;
    return run_lode({"verify", folder_, "--against", dem_, "--json"});
  };
  const char* coverage = "tiles cover the raster, on every level";
  const char* parents = "each level has tiles, and each tile a parent";
  EXPECT_TRUE(passes(verify(layer), coverage));
  auto fewer = layer;
  fewer["available"][last][0]["startX"] = fewer["available"][last][0]["endX"];
  EXPECT_FALSE(passes(verify(fewer), coverage));
  fewer = layer;
  fewer["available"][last] = nlohmann::json::array();
  EXPECT_FALSE(passes(verify(fewer), coverage));
  EXPECT_FALSE(passes(verify(fewer), parents));
  fewer = layer;
  fewer["available"][0] = nlohmann::json::parse(R"([{"startX":0,"endX":0,"startY":0,"endY":0}])");
  EXPECT_FALSE(passes(verify(fewer), parents));
}

TEST_F(cli_tiles, are_the_same_when_the_raster_stays_in_its_file) {
  ASSERT_EQ(cut().exit_code, 0);
  const auto whole = files_in(folder_);
  std::filesystem::remove_all(folder_);
  ASSERT_EQ(cut({"--memory-limit", "1K", "--threads", "3"}).exit_code, 0);
  EXPECT_EQ(files_in(folder_), whole);
}

TEST_F(cli_tiles, appear_whole_or_not_at_all) {
  std::filesystem::create_directory(folder_);
  EXPECT_EQ(cut().exit_code, 0);  // an empty folder may be there
  const auto before = files_in(folder_);
  const Finished again = cut();
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_NE(again.err.find("empty"), std::string::npos) << again.err;
  EXPECT_EQ(files_in(folder_), before);
  const auto files = scratch_.files();
  EXPECT_EQ(run_lode({"tiles", dem_, scratch_ / "no/such/tiles", "--max-error", "5"}).exit_code, 1);
  EXPECT_EQ(scratch_.files(), files);
  // What is empty, but nothing can be renamed to.
  std::filesystem::create_directory(scratch_ / "other");
  std::filesystem::create_directory_symlink(scratch_ / "other", scratch_ / "link");
  for (const std::string& path : {std::string(), scratch_ / "link", scratch_ / "link/",
                                  scratch_ / "other/.", scratch_ / "other/.."})
    expect_refusal(run_lode({"tiles", dem_, path, "--max-error", "5"}), 1, {"expected a folder"});
  EXPECT_TRUE(std::filesystem::is_empty(scratch_ / "other"));
  EXPECT_EQ(scratch_.files(), (std::vector<std::string>{"dem.asc", "link", "other", "tiles"}));
}

TEST_F(cli_tiles, are_refused_of_heights_that_there_are_not) {
  for (const char* value : {"-3.4028235e38", "1e39", "1.7e308", "10000001"}) {
    std::ofstream(dem_) << "ncols 3\nnrows 2\nxllcorner 8\nyllcorner 4\ncellsize 1\n1 2 3\n4 "
                        << value << " 6\n";
    expect_refusal(cut_in_words(), 1, {dem_, "row 1", "--nodata"});
    EXPECT_FALSE(std::filesystem::exists(folder_));
  }
  EXPECT_EQ(cut({"--nodata", "10000001"}).exit_code, 0);
  std::filesystem::remove_all(folder_);
  expect_refusal(cut_in_words({"--nodata", "10000001", "--fill", "1e39"}), 2, {"--fill", "1e39"});
}

TEST_F(cli_tiles, are_refused_when_there_would_be_millions) {
  std::ofstream(dem_) << "ncols 40\nnrows 2\nxllcorner 0\nyllcorner 4\ndx 8\ndy 1e-8\n";
  std::ofstream file(dem_, std::ios::app);
  for (int i = 0; i < 80; ++i) file << i << (i == 39 ? '\n' : ' ');
  file.close();
  expect_refusal(cut_in_words(), 1, {dem_, "tiles", "--max-level"});
  EXPECT_EQ(cut({"--max-level", "2"}).exit_code, 0);
}

TEST_F(cli_tiles, are_refused_of_what_is_not_on_the_globe) {
  std::ofstream(dem_)
      << "ncols 2\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n1 2\n3 4\n";
  const Finished metres = cut();
  EXPECT_EQ(metres.exit_code, 1);
  EXPECT_NE(metres.err.find("expected latitudes from -90 to 90"), std::string::npos) << metres.err;
  EXPECT_NE(metres.err.find("--crs and --resample"), std::string::npos) << metres.err;
  EXPECT_FALSE(std::filesystem::exists(folder_));
  EXPECT_EQ(run_lode({"tiles", dem_, folder_, "--max-error", "0"}).exit_code, 2);
  EXPECT_EQ(run_lode({"tiles", dem_, folder_}).exit_code, 2);
  EXPECT_EQ(run_lode({"tiles", dem_, folder_, "--max-error", "1", "--max-level", "40"}).exit_code,
            2);
  EXPECT_EQ(run_lode({"tiles", scratch_ / "points.xyz", folder_, "--max-error", "1"}).exit_code, 2);
}

/// In Kansas, where NAD27 and NAD83, which is within a metre or two of WGS 84, were laid on each
/// other: places differ by some 30 m.
TEST_F(cli_tiles, of_another_datum_are_warned_of_with_how_far_off_they_are) {
  std::ofstream(dem_)
      << "ncols 3\nnrows 3\nxllcorner -99\nyllcorner 39\ncellsize 0.01\n1 2 3\n4 5 6\n7 8 9\n";
  const auto warnings = [&](const std::string& prj) {
    std::ofstream(std::filesystem::path(dem_).replace_extension(".prj")) << prj;
    std::filesystem::remove_all(folder_);
    return run_lode({"tiles", dem_, folder_, "--max-error", "1", "--json"})
        .json()
        .at("warnings")
        .dump();
  };
  const std::string rest = R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
  const std::string nad27 =
      warnings(R"(GEOGCS["NAD27",DATUM["North_American_Datum_1927",SPHEROID["Clarke 1866",)"
               R"(6378206.4,294.978698213898]],)" +
               rest);
  const std::string before = "its middle is put ";
  const std::size_t at = nad27.find(before);
  ASSERT_NE(at, std::string::npos) << nad27;
  const double metres = std::stod(nad27.substr(at + before.size()));
  EXPECT_GT(metres, 10);
  EXPECT_LT(metres, 60);
  EXPECT_NE(nad27.find("--resample cubic"), std::string::npos);
  const std::string wgs84 = warnings(
      R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)" + rest);
  EXPECT_EQ(wgs84.find(before), std::string::npos) << wgs84;
}

/// 60 x 45 heights in UTM's zone 33, ESRI ASCII with what ArcGIS writes beside it.
void write_projected(const std::string& folder) {
  std::ofstream(folder + "utm.prj")
      << R"(PROJCS["WGS_1984_UTM_Zone_33N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",)"
         R"(SPHEROID["WGS_1984",6378137,298.257223563]],PRIMEM["Greenwich",0],)"
         R"(UNIT["Degree",0.017453292519943295]],PROJECTION["Transverse_Mercator"],)"
         R"(PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",15],)"
         R"(PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],)"
         R"(PARAMETER["false_northing",0],UNIT["Meter",1]])";
  std::ofstream file(folder + "utm.asc");
  file << "ncols 60\nnrows 45\nxllcorner 402000\nyllcorner 5201000\ncellsize 100\n";
  for (int y = 0; y < 45; ++y)
    for (int x = 0; x < 60; ++x)
      file << std::lround(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y))
           << (x + 1 < 60 ? ' ' : '\n');
}

TEST_F(cli_tiles, of_rasters_without_heights_are_refused) {
  write_projected(scratch_ / "");
  const std::string utm = scratch_ / "utm.asc";
  std::ofstream file(utm);
  file << "ncols 60\nnrows 45\nxllcorner 402000\nyllcorner 5201000\ncellsize 100\n"
          "nodata_value -9999\n";
  for (int i = 0; i < 60 * 45; ++i) file << "-9999 ";
  file.close();
  expect_refusal(run_lode({"tiles", utm, folder_, "--max-error", "5", "--resample", "cubic"}), 1,
                 {"utm.asc", "samples with heights", "none of"});
  std::filesystem::remove(scratch_ / "utm.prj");
  expect_refusal(run_lode({"tiles", utm, folder_, "--max-error", "5"}), 1, {"utm.asc"});
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

TEST_F(cli_tiles, of_projected_rasters_are_resampled) {
  write_projected(scratch_ / "");
  const std::string utm = scratch_ / "utm.asc";
  const std::vector<std::string> cut{"tiles", utm, folder_, "--max-error", "5"};
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  };
  expect_refusal(run_lode(cut), 1, {"projected raster", "--resample"});
  expect_refusal(with(cut, {"--resample", "lanczos"}), 2, {"--resample", "lanczos"});
  expect_refusal(with(cut, {"--resample", "cubic", "--encoding", "terrarium"}), 2, {"--resample"});
  const Finished made = with(cut, {"--resample", "cubic", "--json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.err.find("put in degrees"), std::string::npos) << made.err;
  const auto off = made.json().at("resampling");
  EXPECT_EQ(off.at("samples"), 60 * 45);
  EXPECT_EQ(off.at("outside"), 0);
  EXPECT_GT(off.at("max_error"), off.at("rms_error"));
  EXPECT_LT(off.at("max_error"), 15);  // of waves of 300 m over 20 samples
  expect_refusal(with(cut, {"--oversample", "2"}), 2, {"--oversample", "--resample"});
  const std::string finer = scratch_ / "finer";
  const Finished more = run_lode({"tiles", utm, finer, "--max-error", "5", "--resample", "cubic",
                                  "--oversample", "3", "--json"});
  EXPECT_LT(more.json().at("resampling").at("max_error"), 0.5 * off.at("max_error").get<double>());
  EXPECT_EQ(
      run_lode({"verify", finer, "--against", utm, "--resample", "cubic", "--oversample", "3"})
          .exit_code,
      0);
  const std::vector<std::string> verify{"verify", folder_, "--against", utm};
  expect_refusal(run_lode(verify), 1, {"--resample"});
  EXPECT_EQ(with(verify, {"--resample", "cubic"}).exit_code, 0);
  EXPECT_EQ(with(verify, {"--resample", "nearest"}).exit_code, 1) << "other samples";
  expect_refusal(
      run_lode({"verify", utm, "--surface", "s.ply", "--max-error", "1", "--resample", "cubic"}), 2,
      {"--resample", "folder of tiles"});
}

}  // namespace
}  // namespace lode::test
