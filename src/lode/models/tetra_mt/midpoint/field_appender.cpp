#include "lode/models/tetra_mt/midpoint/field_appender.h"

#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/midpoint/file_layout.h"
#include "lode/models/tetra_mt/midpoint/persist.h"

namespace lode::tetra_mt::midpoint {

FieldAppender::FieldAppender(const Forest& forest, store::Writer writer)
    : forest_(&forest), head_(forest.head()), writer_(std::move(writer)) {}

Result<FieldAppender> FieldAppender::create(const std::string& model, const Forest& forest,
                                            const std::string& output, const Progress& progress) {
  LODE_TRY(auto writer, copy_blocks(model, output, kModelName, progress));
  return FieldAppender(forest, std::move(writer));
}

Result<void> FieldAppender::append(FieldRecords field, Threads threads, Progress& progress) {
  const std::size_t number = head_.fields.size();
  if (number >= kMaxFields)
    return fail("{}: expected up to {} fields, got more", field.head.name, kMaxFields);
  head_.fields.push_back(std::move(field.head));
  // So that all are there.
  for (std::uint32_t page = 0; page < head_.pages.n_pages(); ++page)
    if (forest_->page(page) == nullptr) return forest_->check();
  LODE_CHECK(append_field(
      head_, number, field.records, [this](std::uint32_t page) { return *forest_->page(page); },
      threads, writer_, progress));
  return append_world_errors(head_, number, field.world_codes, writer_);
}

Result<std::uint64_t> FieldAppender::finish(const Progress& progress) {
  writer_.set_metadata(encode_head(head_));
  return writer_.finish(progress);
}

}  // namespace lode::tetra_mt::midpoint
