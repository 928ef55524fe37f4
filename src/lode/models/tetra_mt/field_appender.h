#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/store/writer.h"

namespace lode::tetra_mt {

/// Makes a file of all that another one has, block by block as it is, and further fields. It
/// appears whole or not at all.
class FieldAppender {
 public:
  /// Copies what is there. `hierarchy`: the model's, which must outlive the appender.
  [[nodiscard]] static Result<FieldAppender> create(const std::string& model,
                                                    const PackedHierarchy& hierarchy,
                                                    const std::string& output, Progress& progress);

  /// `gradients`: gradient_code()s by vertex.
  [[nodiscard]] Result<void> append(const NumberedField& field,
                                    std::span<const std::uint32_t> gradients, Threads threads);
  /// With all fields so far.
  [[nodiscard]] const HierarchyHead& head() const { return head_; }
  /// Adds to what the record says of how fields were read.
  void add_notes(std::span<const BuildRecord::Note> notes) {
    head_.record.notes.insert(head_.record.notes.end(), notes.begin(), notes.end());
  }
  /// The file's size. Nothing may be called afterwards.
  [[nodiscard]] Result<std::uint64_t> finish(const Progress& progress);

 private:
  FieldAppender(const PackedHierarchy& hierarchy, store::Writer writer);

  const PackedHierarchy* hierarchy_;
  HierarchyHead head_;
  store::Writer writer_;
};

}  // namespace lode::tetra_mt
