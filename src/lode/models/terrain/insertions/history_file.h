#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/page.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/models/terrain/insertions/tolerance_steps.h"
#include "lode/store/reader.h"

namespace lode::insertions {

/// A file of these models, of which pages are read when they are asked for. Const members are safe
/// from many threads.
class HistoryFile {
 public:
  /// Reads what says where things are, and the base. Fails, naming the file, on all that is not as
  /// docs/format.md says.
  [[nodiscard]] static Result<HistoryFile> open(const std::string& path);

  [[nodiscard]] const std::string& path() const { return reader_->path(); }
  /// Without nodes.
  [[nodiscard]] const History& base() const { return head_.history; }
  [[nodiscard]] const std::vector<double>& levels() const { return head_.levels; }
  [[nodiscard]] const std::vector<LevelFacts>& facts() const { return head_.facts; }
  [[nodiscard]] std::uint32_t n_nodes() const { return bands_.empty() ? 0 : bands_.back().end; }
  /// That there ever were.
  [[nodiscard]] std::uint32_t n_triangles() const { return n_triangles_; }
  [[nodiscard]] std::span<const ToleranceStep> steps() const { return steps_; }
  [[nodiscard]] std::span<const Band> bands() const { return bands_; }
  [[nodiscard]] std::span<const PageEntry> pages() const { return pages_; }
  /// Its pages' boxes, numbered from its first.
  [[nodiscard]] const BoxTree& boxes_of(std::size_t band) const { return boxes_[band]; }
  [[nodiscard]] std::size_t band_of_page(std::uint32_t page) const;
  /// The first bands that have all nodes before a time.
  [[nodiscard]] std::size_t n_bands_before(std::uint32_t time) const;
  /// What History::n_bytes() is of all of it.
  [[nodiscard]] std::uint64_t n_history_bytes() const;

  /// Each fails where the page is not as docs/format.md says.
  [[nodiscard]] Result<PageNodes> read_nodes(std::uint32_t page) const;
  /// Of the triangles that its nodes make, one after the other.
  [[nodiscard]] Result<std::vector<float>> read_errors(std::uint32_t page) const;

  /// Since it was opened.
  [[nodiscard]] store::ReadCounts reads() const { return reader_->reads(); }

 private:
  explicit HistoryFile(store::Reader reader)
      : reader_(std::make_unique<const store::Reader>(std::move(reader))) {}
  [[nodiscard]] Result<void> read_steps(std::uint32_t n);
  [[nodiscard]] Result<void> read_index();
  [[nodiscard]] Result<void> check_pages() const;

  std::unique_ptr<const store::Reader> reader_;
  LevelledHistory head_;
  HeightType type_ = HeightType::float64;
  std::uint32_t n_triangles_ = 0;
  std::vector<ToleranceStep> steps_;
  std::vector<Band> bands_;
  std::vector<PageEntry> pages_;
  std::vector<BoxTree> boxes_;
};

}  // namespace lode::insertions
