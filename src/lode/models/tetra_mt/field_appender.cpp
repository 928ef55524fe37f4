#include "lode/models/tetra_mt/field_appender.h"

#include <utility>

#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/reader.h"

namespace lode::tetra_mt {

FieldAppender::FieldAppender(const PackedHierarchy& hierarchy, store::Writer writer)
    : hierarchy_(&hierarchy), head_(hierarchy.head()), writer_(std::move(writer)) {}

Result<FieldAppender> FieldAppender::create(const std::string& model,
                                            const PackedHierarchy& hierarchy,
                                            const std::string& output, Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(model));
  LODE_TRY(auto writer, store::Writer::create(output, kModelName, {}));
  const auto blocks = reader.blocks();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const auto bytes, reader.read_block(i));
    LODE_CHECK(writer.append(
        blocks[i].key, store::encode_block_as(store::Codec::none, {.raw = bytes, .size = 1})));
  }
  return FieldAppender(hierarchy, std::move(writer));
}

Result<void> FieldAppender::append(const NumberedField& field,
                                   std::span<const std::uint32_t> gradients, Threads threads) {
  const auto tree_of = [this](std::uint32_t page) { return hierarchy_->tree_of(page); };
  return append_field(field, gradients, tree_of, head_, threads, writer_);
}

Result<std::uint64_t> FieldAppender::finish(const Progress& progress) {
  writer_.set_metadata(encode_head(head_));
  return writer_.finish(progress);
}

}  // namespace lode::tetra_mt
