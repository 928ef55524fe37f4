#include <nlohmann/json.hpp>

#include "tests/io/zarr_fixtures.h"

namespace lode::io {
namespace {

using nlohmann::json;
using test::expect_failure;
using test::gzipped;
using test::read_volume;
using test::zlibbed;

struct MetadataChange {
  const char* pointer;  ///< JSON pointer.
  const char* value;
  const char* message;
};

void expect_refused(const std::string& fixture_name, const std::string& file,
                    std::span<const MetadataChange> changes) {
  const test::ZarrFixture fixture(fixture_name);
  const std::string original = fixture.read(file);
  for (const MetadataChange& change : changes) {
    SCOPED_TRACE(fmt::format("{} = {}", change.pointer, change.value));
    json metadata = json::parse(original);
    metadata[json::json_pointer(change.pointer)] = json::parse(change.value);
    fixture.write(file, metadata.dump());
    expect_failure(fixture.path(), {file, change.message});
  }
}

TEST(zarr_v2_reader, refuses_hostile_metadata) {
  const MetadataChange changes[] = {
      {"/zarr_format", "3", "zarr_format 2"},
      {"/shape", "[]", "2 to 5 axes, got 0"},
      {"/shape", "[3]", "2 to 5 axes, got 1"},
      {"/shape", "[1, 1, 1, 3, 7, 10]", "at most 5 whole numbers for shape"},
      {"/shape", "[3, 7]", "chunks of 2 axes, got 3"},
      {"/shape", "[3, -7, 10]", "along axis 1 of an array and its chunks, got -7"},
      {"/shape", "[3, 0, 10]", "got 0"},
      {"/shape", "[3, 7, 2147483647]", "got 2147483647"},
      {"/shape", "[2147483646, 2147483646, 2147483646]", "more than 2^63"},
      {"/shape", "[3, 7, 18446744073709551615]", "whole numbers for shape"},
      {"/shape", "[3, 7, 10.0]", "whole numbers for shape"},
      {"/shape", "[3, 7, null]", "whole numbers for shape"},
      {"/shape", "\"many\"", "whole numbers for shape, got '\"many\"'"},
      {"/chunks", "[2, 4, 0]", "got 0"},
      {"/chunks", "[2, 4, -5]", "got -5"},
      {"/chunks", "[2, 4]", "chunks of 3 axes, got 2"},
      {"/chunks", "[2147483646, 2147483646, 2147483646]", "more than 2^63"},
      {"/chunks", "[1024, 1024, 1024]", "at most 2147483647 bytes, got 2147483648"},
      {"/dtype", "\"<f2\"", "got '\"<f2\"'"},
      {"/dtype", "\"|u2\"", "byte order"},
      {"/dtype", "\"<i2 \"", "byte order"},
      {"/dtype", "\"\"", "byte order"},
      {"/dtype", "[[\"r\", \"<u2\"]]", "byte order"},
      {"/dtype", "null", "byte order"},
      {"/order", "\"A\"", "order C or F"},
      {"/order", "null", "text for order"},
      {"/compressor", "{\"id\": \"lzma\"}", "'lzma'"},
      {"/compressor", "{}", "text for id, got nothing"},
      {"/compressor", "7", "text for id"},
      {"/filters", "[{\"id\": \"delta\", \"dtype\": \"<i2\"}]", "expected no filters"},
      {"/fill_value", "40000", "fill_value of type int16, got '40000'"},
      {"/fill_value", "-32769", "fill_value of type int16"},
      {"/fill_value", "1.5", "fill_value of type int16"},
      {"/fill_value", "\"NaN\"", "fill_value of type int16"},
      {"/fill_value", "[0]", "fill_value of type int16"},
      {"/dimension_separator", "\"_\"", "dimension_separator"},
  };
  expect_refused("v2/fill_42", ".zarray", changes);
  const MetadataChange floating[] = {{"/fill_value", "1e39", "fill_value of type float32"},
                                     {"/fill_value", "\"nan\"", "fill_value of type float32"},
                                     {"/fill_value", "true", "fill_value of type float32"}};
  expect_refused("v2/fill_nan", ".zarray", floating);
}

TEST(zarr_v3_reader, refuses_hostile_metadata) {
  const MetadataChange changes[] = {
      {"/zarr_format", "2", "zarr_format 3"},
      {"/node_type", "\"grid\"", "node_type array or group, got 'grid'"},
      {"/node_type", "null", "text for node_type"},
      {"/shape", "[3, 7, -10]", "got -10"},
      {"/shape", "[3, 7]", "dimension_names"},
      {"/shape", "[3, 7, 10, 1]", "4"},
      {"/data_type", "\"float16\"", "'float16'"},
      {"/data_type", "{\"name\": \"numpy.datetime64\"}", "'numpy.datetime64'"},
      {"/data_type", "{}", "a name for data_type"},
      {"/chunk_grid/name", "\"rectangular\"", "regular chunk_grid, got 'rectangular'"},
      {"/chunk_grid/configuration", "[]", "an object for the configuration of 'regular'"},
      {"/chunk_grid/configuration/chunk_shape", "[2, 4, 0]", "got 0"},
      {"/chunk_grid/configuration/chunk_shape", "[2, 4]", "chunks of 3 axes, got 2"},
      {"/chunk_grid/configuration/chunk_shape", "[1290, 1290, 1290]", "at most 2147483647 bytes"},
      {"/chunk_key_encoding", "{\"name\": \"hilbert\"}", "'hilbert'"},
      {"/chunk_key_encoding/configuration/separator", "\"..\"", "separator"},
      {"/chunk_key_encoding/configuration/separator", "7", "text for separator"},
      {"/fill_value", "\"0x0000\"", "fill_value"},
      {"/fill_value", "70000", "fill_value"},
      {"/codecs", "[]", "bytes or sharding_indexed"},
      {"/codecs", "{}", "a list of at most 16 codecs"},
      {"/codecs", "[7]", "a name for a codec"},
      {"/codecs", "[\"lz77\"]", "'lz77'"},
      {"/codecs", "[\"gzip\", \"bytes\"]", "'gzip' behind"},
      {"/codecs", "[\"bytes\"]", "text for endian"},
      {"/codecs", "[{\"name\": \"bytes\", \"configuration\": {\"endian\": \"middle\"}}]", "middle"},
      {"/codecs/1", "{\"name\": \"bytes\", \"configuration\": {\"endian\": \"big\"}}",
       "before any"},
      {"/codecs/1", "{\"name\": \"transpose\", \"configuration\": {\"order\": [0,1,2]}}",
       "before any"},
      {"/codecs/2", "\"gzip\"", "one compressor at most"},
      {"/codecs/1", "{\"name\": \"numcodecs.delta\", \"must_understand\": false}",
       "'numcodecs.delta'"},
      {"/dimension_names", "[\"z\", \"y\"]", "3 dimension_names"},
      {"/dimension_names", "[\"z\", \"y\", 7]", "3 dimension_names"},
      {"/storage_transformers", "[\"secret\"]", "storage_transformers"},
      {"/extension", "{\"name\": \"extension\"}", "must be understood: 'extension'"},
      {"/extension", "{\"must_understand\": true}", "must be understood: 'extension'"},
  };
  const test::ZarrFixture fixture("v3/codec_zstd");
  json metadata = json::parse(fixture.read("zarr.json"));
  metadata["dimension_names"] = {"z", nullptr, "x"};
  metadata["extra"] = {{"must_understand", false}};
  fixture.write("zarr.json", metadata.dump());
  const auto volume = read_volume(fixture.path());
  EXPECT_TRUE(volume) << volume.error().message;
  const std::string original = metadata.dump();
  for (const MetadataChange& change : changes) {
    SCOPED_TRACE(fmt::format("{} = {}", change.pointer, change.value));
    json changed = metadata;
    changed[json::json_pointer(change.pointer)] = json::parse(change.value);
    fixture.write("zarr.json", changed.dump());
    expect_failure(fixture.path(), {"zarr.json", change.message});
  }
}

TEST(zarr_v3_reader, refuses_transposes_that_are_no_order_of_the_axes) {
  const MetadataChange changes[] = {
      {"/codecs/0/configuration/order", "[0, 1]", "3 axes in transpose"},
      {"/codecs/0/configuration/order", "[0, 1, 1]", "3 axes in transpose"},
      {"/codecs/0/configuration/order", "[0, 1, 3]", "3 axes in transpose"},
      {"/codecs/0/configuration/order", "[0, 1, -1]", "3 axes in transpose"},
      {"/codecs/0/configuration/order", "[0, 1, 4294967296]", "3 axes in transpose"},
      {"/codecs/0/configuration/order", "\"F\"", "whole numbers for order"},
      {"/codecs/0/configuration", "{}", "whole numbers for order, got nothing"},
  };
  expect_refused("v3/transpose_120", "zarr.json", changes);
}

TEST(zarr_shards, refuse_hostile_metadata) {
  const MetadataChange changes[] = {
      {"/codecs/0/configuration/chunk_shape", "[2, 4, 3]", "divide their shard, got 3 in 5"},
      {"/codecs/0/configuration/chunk_shape", "[2, 4, 0]", "divide their shard"},
      {"/codecs/0/configuration/chunk_shape", "[2, 4, -5]", "divide their shard"},
      {"/codecs/0/configuration/chunk_shape", "[2, 4]", "chunks in shards of 3 axes, got 2"},
      {"/codecs/0/configuration/codecs", "[]", "bytes or sharding_indexed"},
      {"/codecs/0/configuration/codecs/1", "\"lz4\"", "'lz4'"},
      {"/codecs/0/configuration/index_codecs", "[]", "bytes or sharding_indexed"},
      {"/codecs/0/configuration/index_codecs", "null", "list of at most 16 codecs"},
      {"/codecs/0/configuration/index_codecs/1", "\"gzip\"", "index_codecs of bytes and crc32c"},
      {"/codecs/0/configuration/index_location", "\"middle\"", "start or end"},
      {"/codecs/1", "\"zstd\"", "none round shards"},
      {"/chunk_grid/configuration/chunk_shape", "[2, 33554432, 5]", "4194304 chunks in a shard"},
      {"/chunk_grid/configuration/chunk_shape", "[2147483646, 2147483644, 2147483645]", "2^63"},
  };
  expect_refused("v3/shard_zstd", "zarr.json", changes);
  // Shards in shards in shards ...
  const test::ZarrFixture fixture("v3/shard_zstd");
  json metadata = json::parse(fixture.read("zarr.json"));
  for (int depth = 1; depth < 4; ++depth) {
    json shard = metadata["codecs"][0];
    shard["configuration"]["codecs"] = metadata["codecs"];
    metadata["codecs"][0] = shard;
  }
  fixture.write("zarr.json", metadata.dump());
  expect_failure(fixture.path(), {"zarr.json", "at most 3 shards inside one another"});
}

TEST(zarr_reader, refuses_files_that_are_no_small_json_objects) {
  for (const auto& [name, file] : {std::pair{"v2/fill_42", ".zarray"},
                                   {"v3/rank2", "zarr.json"},
                                   {"v2/image", ".zattrs"},
                                   {"v3/image", "zarr.json"}}) {
    const test::ZarrFixture fixture(name);
    fixture.write(file, "");
    expect_failure(fixture.path(), {file, "empty"});
    fixture.write(file, "[1, 2]");
    expect_failure(fixture.path(), {file, "a JSON object, got '[1,2]'"});
    fixture.write(file, "{\"shape\": [1, 2");
    expect_failure(fixture.path(), {file, "expected JSON"});
    fixture.write(file, "{\"shape\": 1e999}");
    expect_failure(fixture.path(), {file});
    for (const char* bracket : {"[", "{\"a\":"}) {
      std::string deep = "{\"a\":";
      for (int i = 0; i < 100000; ++i) deep += bracket;
      fixture.write(file, deep);
      expect_failure(fixture.path(), {file, "at most 64 levels deep"});
    }
    fixture.write(file, std::string((8 << 20) + 1, ' '));
    expect_failure(fixture.path(), {file, "at most 8388608 bytes of metadata"});
    std::filesystem::remove(fixture.path(file));
    std::filesystem::create_directory(fixture.path(file));
    expect_failure(fixture.path(), {file, "got a directory"});
  }
}

TEST(zarr_reader, refuses_chunks_that_are_no_files) {
  const test::ZarrFixture fixture("v2/codec_raw");
  const std::string chunk = fixture.path("0.1.0");
  std::filesystem::remove(chunk);
  std::filesystem::create_directory(chunk);
  expect_failure(fixture.path(), {chunk, "got a directory"});
  std::filesystem::remove(chunk);
  std::filesystem::create_symlink("nowhere", chunk);
  expect_failure(fixture.path(), {chunk, "cannot be opened"});
  const test::ZarrFixture slashes("v2/slashes");
  std::filesystem::remove_all(slashes.path("0"));
  slashes.write("0", "a file");
  expect_failure(slashes.path(), {slashes.path("0/0/0"), "cannot be opened"});
}

TEST(zarr_reader, refuses_chunks_of_another_size) {
  constexpr std::size_t kChunkBytes = 8 * 16 * 20 * 2;
  const std::pair<const char*, std::string (*)(const std::string&)> encodings[] = {
      {"v2/codec_raw", [](const std::string& bytes) { return bytes; }},
      {"v2/codec_gzip", gzipped},
      {"v2/codec_zlib", zlibbed}};
  for (const auto& [name, encode] : encodings) {
    const test::ZarrFixture fixture(name);
    for (const std::size_t n : {kChunkBytes - 1, kChunkBytes + 1, 3 * kChunkBytes}) {
      fixture.write("0.0.1", encode(std::string(n, 'a')));
      expect_failure(fixture.path(), {fixture.path("0.0.1"), fmt::format("{}", kChunkBytes)});
    }
    fixture.write("0.0.1", encode(std::string(kChunkBytes, 'a')));
    EXPECT_TRUE(read_volume(fixture.path())) << name;
  }
  // The chunk of another array: whole and good, but of 80 bytes.
  const test::ZarrFixture small("v3/shard_zstd");
  for (const char* name : {"v3/codec_zstd", "v2/codec_blosc_zstd_none"}) {
    const test::ZarrFixture fixture(name);
    const std::string chunk = std::string(name).starts_with("v3") ? "c/0/0/1" : "0.0.1";
    fixture.write(chunk, small.read("c/0/0/0").substr(0, 60));
    expect_failure(fixture.path(), {fixture.path(chunk)});
    fixture.write(chunk, std::string(100000, 'a'));
    expect_failure(fixture.path(), {fixture.path(chunk), "at most"});
    fixture.write(chunk, "a");
    expect_failure(fixture.path(), {fixture.path(chunk)});
  }
}

TEST(zarr_reader, refuses_truncated_chunks_of_every_codec) {
  for (const char* name :
       {"v2/codec_raw", "v2/codec_gzip", "v2/codec_zlib", "v2/codec_zstd",
        "v2/codec_blosc_lz4_bytes", "v2/codec_blosc_zlib_none", "v2/codec_blosc_blosclz_bits"}) {
    const test::ZarrFixture fixture(name);
    const std::string chunk = fixture.read("0.0.1");
    // The last 8 bytes of gzip are its checksum and size, which are looked at too.
    const std::size_t step = chunk.size() / 40 + 1;
    for (std::size_t n = 0; n < chunk.size(); n += step) {
      fixture.write("0.0.1", chunk.substr(0, n));
      expect_failure(fixture.path(), {fixture.path("0.0.1")});
    }
    fixture.write("0.0.1", chunk.substr(0, chunk.size() - 1));
    expect_failure(fixture.path(), {fixture.path("0.0.1")});
  }
}

TEST(zarr_reader, notices_flipped_bytes_in_chunks_with_a_checksum) {
  for (const char* name : {"v3/codec_crc32c", "v3/codec_gzip_crc32c", "v3/codec_zstd_crc32c",
                           "v3/codec_crc32c_gzip"}) {
    const test::ZarrFixture fixture(name);
    const std::string chunk = fixture.read("c/0/1/0");
    const std::size_t step = chunk.size() / 60 + 1;
    // A gzip header has bytes that mean nothing (time, system), so behind it where it is outside.
    const std::size_t first = std::string(name).ends_with("crc32c_gzip") ? 10 : 0;
    for (std::size_t at = first; at < chunk.size(); at += step) {
      std::string flipped = chunk;
      flipped[at] = static_cast<char>(flipped[at] ^ 0x20);
      fixture.write("c/0/1/0", flipped);
      expect_failure(fixture.path(), {fixture.path("c/0/1/0")});
    }
    for (std::size_t n = 1; n < 4; ++n) {
      fixture.write("c/0/1/0", chunk.substr(0, n));
      expect_failure(fixture.path(), {fixture.path("c/0/1/0")});
    }
  }
}

}  // namespace
}  // namespace lode::io
