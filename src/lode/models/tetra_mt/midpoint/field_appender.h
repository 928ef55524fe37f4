#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "lode/core/progress.h"
#include "lode/models/tetra_mt/midpoint/field_records.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt::midpoint {

/// Makes a file of all that another one has, block by block as it is, and further fields. It
/// appears whole or not at all.
class FieldAppender {
 public:
  /// Copies what is there. `forest`: the model's, from its file, which must outlive the appender.
  [[nodiscard]] static Result<FieldAppender> create(const std::string& model, const Forest& forest,
                                                    const std::string& output,
                                                    const Progress& progress);

  /// Fails where pages cannot be loaded, there are too many fields, or when cancelled.
  [[nodiscard]] Result<void> append(FieldRecords field, Threads threads, Progress& progress);
  /// With all fields so far.
  [[nodiscard]] const ForestHead& head() const { return head_; }
  /// Adds to what the record says of how fields were read.
  void add_notes(std::span<const BuildRecord::Note> notes) {
    head_.record.notes.insert(head_.record.notes.end(), notes.begin(), notes.end());
  }
  /// The file's size. Nothing may be called afterwards.
  [[nodiscard]] Result<std::uint64_t> finish(const Progress& progress);

 private:
  FieldAppender(const Forest& forest, store::Writer writer);

  const Forest* forest_;
  ForestHead head_;
  store::Writer writer_;
};

}  // namespace lode::tetra_mt::midpoint
