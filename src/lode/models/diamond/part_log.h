#pragma once

#include <string>
#include <vector>

#include "lode/models/diamond/part_builder.h"
#include "lode/store/journal.h"

namespace lode::diamond {

/// What a build has done so far.
struct PartsDone {
  std::size_t n_chunks = 0;               ///< In the order of the file.
  std::vector<store::BlockEntry> blocks;  ///< All that are in the file.
  std::vector<ErrorCode> largest_errors;  ///< PartBuilder::largest_errors().
};

/// The journal of a build: after each part the blocks that were written and the part's shares of
/// the coarse nodes, so that another process can go on from there. Some n / 36 bytes for n samples,
/// before compression.
template <int D>
class PartLog {
 public:
  [[nodiscard]] static std::string path_of(const std::string& output) {
    return AtomicFile::part_path(output) + ".journal";
  }
  /// `head` says of what field the build is.
  [[nodiscard]] static Result<PartLog> create(const std::string& output,
                                              std::span<const std::byte> head);
  /// Joins the shares of an earlier build with the field's nodes. Nothing is done where there was
  /// none. Fails when it had another head.
  [[nodiscard]] static Result<PartLog> resume(const std::string& output,
                                              std::span<const std::byte> head,
                                              CoarseField<D>& field, PartsDone& done);

  /// After a part; `done` is what is done with it. All blocks must be on disk.
  [[nodiscard]] Result<void> add(const PartPlan<D>& plan, const CoarseField<D>& field,
                                 const PartsDone& done);
  void remove() { journal_.remove(); }
  /// Removes what earlier builds of an output that is finished now have left, unless another
  /// process is at it.
  static void remove_leftovers(const std::string& output);

 private:
  PartLog(store::Journal journal, std::size_t n_blocks)
      : journal_(std::move(journal)), n_blocks_(n_blocks) {}

  store::Journal journal_;
  std::size_t n_blocks_ = 0;  ///< In earlier records.
};

extern template class PartLog<2>;
extern template class PartLog<3>;

}  // namespace lode::diamond
