#include <algorithm>
#include <nlohmann/json.hpp>

#include "lode/io/text.h"
#include "lode/io/zarr_json.h"
#include "lode/io/zarr_metadata.h"

namespace lode::io {
namespace {

using nlohmann::json;

/// More than any use of them; a list of codecs is read by recursion.
constexpr int kMaxShardDepth = 3;
constexpr std::size_t kMaxCodecs = 16;

bool is_compressor(ZarrBytesCodec codec) { return codec != ZarrBytesCodec::crc32c; }

/// Builds ZarrCodecs from a list, codec by codec.
class CodecListParser {
 public:
  CodecListParser(const std::string& path, const ZarrCodedArray& array, int depth)
      : path_(path), array_(array), depth_(depth) {}

  Result<ZarrCodecs> parse(const json* list) {
    if (list == nullptr || !list->is_array() || list->size() > kMaxCodecs)
      return fail("{}: expected a list of at most {} codecs, got {}", path_, kMaxCodecs,
                  quoted_json(list));
    for (const json& each : *list) {
      LODE_TRY(const ZarrExtension codec, parse_zarr_extension(path_, &each, "a codec"));
      LODE_CHECK(add(codec));
    }
    if (!has_bytes_)
      return fail("{}: expected the codec bytes or sharding_indexed in the list, got {}", path_,
                  quoted_json(*list));
    return std::move(codecs_);
  }

 private:
  Result<void> add(const ZarrExtension& codec) {
    if (codec.name == "transpose") return add_transpose(codec);
    if (codec.name == "bytes") return add_bytes(codec);
    if (codec.name == "sharding_indexed") return add_shard(codec);
    if (codec.name == "gzip") return add_bytes_codec(codec, ZarrBytesCodec::gzip);
    if (codec.name == "zstd") return add_bytes_codec(codec, ZarrBytesCodec::zstd);
    if (codec.name == "blosc") return add_bytes_codec(codec, ZarrBytesCodec::blosc);
    if (codec.name == "crc32c") return add_bytes_codec(codec, ZarrBytesCodec::crc32c);
    return fail(
        "{}: expected the codecs transpose, bytes, sharding_indexed, gzip, zstd, blosc or crc32c, "
        "got {}",
        path_, in_quotes(codec.name));
  }

  /// Whether the place of a codec in the list is before or behind the one that makes bytes.
  Result<void> expect_bytes(const ZarrExtension& codec, bool is_behind) const {
    if (has_bytes_ == is_behind) return {};
    return fail("{}: expected the codec {} {} bytes or sharding_indexed", path_,
                in_quotes(codec.name), is_behind ? "behind" : "before any");
  }

  Result<void> add_transpose(const ZarrExtension& codec) {
    LODE_CHECK(expect_bytes(codec, false));
    LODE_TRY(const auto order,
             json_whole_numbers(path_, *codec.configuration, "order", array_.rank));
    std::vector<std::size_t> axes(array_.rank);
    for (std::size_t axis = 0; axis < axes.size(); ++axis) axes[axis] = axis;
    if (!std::is_permutation(order.begin(), order.end(), axes.begin(), axes.end()))
      return fail("{}: expected an order of {} axes in transpose, got {}", path_, array_.rank,
                  quoted_json(codec.configuration));
    if (codecs_.order.empty()) codecs_.order = axes;
    for (std::size_t& axis : axes) axis = codecs_.order[static_cast<std::size_t>(order[axis])];
    codecs_.order = axes;
    return {};
  }

  Result<void> add_bytes(const ZarrExtension& codec) {
    LODE_CHECK(expect_bytes(codec, false));
    has_bytes_ = true;
    const json* endian = find_member(*codec.configuration, "endian");
    if (endian == nullptr && size_of(array_.type) == 1) return {};
    LODE_TRY(const std::string order, json_text(path_, *codec.configuration, "endian"));
    if (order != "little" && order != "big")
      return fail("{}: expected an endian little or big, got {}", path_, in_quotes(order));
    codecs_.byte_order = order == "big" ? ByteOrder::big : ByteOrder::little;
    return {};
  }

  Result<void> add_bytes_codec(const ZarrExtension& codec, ZarrBytesCodec kind) {
    LODE_CHECK(expect_bytes(codec, true));
    auto& list = codecs_.bytes_codecs;
    const bool is_second = std::any_of(list.begin(), list.end(), is_compressor);
    if (is_compressor(kind) && (is_second || codecs_.shard != nullptr))
      return fail("{}: expected one compressor at most, and none round shards, got also {}", path_,
                  in_quotes(codec.name));
    list.push_back(kind);
    return {};
  }

  Result<void> add_shard(const ZarrExtension& codec) {
    LODE_CHECK(expect_bytes(codec, false));
    has_bytes_ = true;
    if (depth_ >= kMaxShardDepth)
      return fail("{}: expected at most {} shards inside one another, got more", path_,
                  kMaxShardDepth);
    const json& configuration = *codec.configuration;
    ZarrShard shard;
    LODE_TRY(shard.chunk_shape,
             json_whole_numbers(path_, configuration, "chunk_shape", array_.rank));
    LODE_TRY(
        shard.codecs,
        CodecListParser(path_, array_, depth_ + 1).parse(find_member(configuration, "codecs")));
    LODE_CHECK(parse_index(configuration, shard));
    codecs_.shard = std::make_shared<const ZarrShard>(std::move(shard));
    return {};
  }

  Result<void> parse_index(const json& configuration, ZarrShard& shard) const {
    if (const json* place = find_member(configuration, "index_location")) {
      if (!json_is(*place, "start") && !json_is(*place, "end"))
        return fail("{}: expected an index_location start or end, got {}", path_,
                    quoted_json(*place));
      shard.index_place = json_is(*place, "start") ? ZarrIndexPlace::start : ZarrIndexPlace::end;
    }
    const ZarrCodedArray index{array_.rank + 1, ScalarType::uint64};
    LODE_TRY(const ZarrCodecs codecs, CodecListParser(path_, index, kMaxShardDepth)
                                          .parse(find_member(configuration, "index_codecs")));
    const auto& list = codecs.bytes_codecs;
    if (!codecs.order.empty() || std::any_of(list.begin(), list.end(), is_compressor))
      return fail("{}: expected index_codecs of bytes and crc32c, got {}", path_,
                  quoted_json(find_member(configuration, "index_codecs")));
    shard.index_byte_order = codecs.byte_order;
    shard.n_index_checksums = list.size();
    return {};
  }

  const std::string& path_;
  ZarrCodedArray array_;
  int depth_;
  bool has_bytes_ = false;
  ZarrCodecs codecs_;
};

}  // namespace

Result<ZarrCodecs> parse_zarr_codecs(const std::string& path, const json* list,
                                     const ZarrCodedArray& array) {
  return CodecListParser(path, array, 0).parse(list);
}

}  // namespace lode::io
