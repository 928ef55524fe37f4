#include "lode/models/tetra_mt/field_appender.h"

#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/persist.h"

namespace lode::tetra_mt {

FieldAppender::FieldAppender(const PackedHierarchy& hierarchy, store::Writer writer)
    : hierarchy_(&hierarchy), head_(hierarchy.head()), writer_(std::move(writer)) {}

Result<FieldAppender> FieldAppender::create(const std::string& model,
                                            const PackedHierarchy& hierarchy,
                                            const std::string& output, Progress& progress) {
  LODE_TRY(auto writer, copy_blocks(model, output, kModelName, progress));
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
