#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"
#include "lode/delaunay/window.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/start_finder.h"

namespace lode::delaunay_pyramid {

using delaunay::Window;
using insertions::History;
using insertions::StartFinder;

/// Lists of numbers one after the other.
struct LinkLists {
  std::vector<std::uint64_t> first;  ///< By owner, and one more; empty: there are none.
  std::vector<std::uint32_t> items;

  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t owner) const {
    return std::span(items).subspan(first[owner], first[owner + 1] - first[owner]);
  }
  [[nodiscard]] std::uint64_t n_bytes() const {
    return first.size() * sizeof(first[0]) + items.size() * sizeof(items[0]);
  }
};

/// How much memory interference links may take with their offsets, also while they are made, when
/// arrays that grow are there twice; more is refused, as links of two levels may be as many as the
/// product of their triangles.
struct EncodingLimit {
  std::uint64_t n_bytes = std::uint64_t{8} << 30;
};

/// The complete data structure (L. De Floriani, 1989): all triangles of each level, what is beside
/// them, and their interference links: the triangles of the next level whose interiors meet theirs,
/// also where that is the triangle itself.
class CompletePyramid {
 public:
  struct Level {
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Vertices of the history.
    std::vector<std::array<std::uint32_t, 3>> twins;      ///< As LatticeTriangle::twin.
    LinkLists links;                                      ///< None of the last level.
  };

  [[nodiscard]] static Result<CompletePyramid> make(const History& history,
                                                    std::span<const std::uint32_t> times,
                                                    EncodingLimit limit, Progress& progress);

  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  /// Gives them away.
  [[nodiscard]] std::vector<Level> take_levels() && { return std::move(levels_); }
  [[nodiscard]] std::uint64_t n_links() const;
  [[nodiscard]] std::uint64_t n_bytes() const;
  /// Of the history it was made of. Without errors.
  [[nodiscard]] delaunay::Tin extract(const History& history, std::size_t level) const;
  /// A triangle of the level that holds p, down the links from one of the first level.
  [[nodiscard]] std::optional<std::uint32_t> locate(const History& history, std::size_t level,
                                                    delaunay::LatticePoint p) const;
  /// The triangles of a level that meet a window, down the links, in the order of their numbers.
  [[nodiscard]] std::vector<std::uint32_t> zoom(const History& history, std::size_t level,
                                                const Window& window) const;

 private:
  std::vector<Level> levels_;
  std::optional<StartFinder> start_;  ///< Of the first level.
};

/// Whether the lists of triangles have interference links.
enum class Interference : std::uint8_t { left_out, linked };

/// The sequence of lists of triangles (M. Bertolotto, L. De Floriani, P. Marzano, "An efficient
/// representation for pyramidal terrain models", 1994): each triangle once, in the list of the
/// level that made it, and the first level that has it no more. With links: to those of that level
/// whose interiors meet its own.
class TriangleLists {
 public:
  struct Entry {
    std::array<std::uint32_t, 3> corner;  ///< Vertices of the history.
    std::uint32_t death;                  ///< Level, or the number of levels.
  };

  [[nodiscard]] static Result<TriangleLists> make(const History& history,
                                                  std::span<const std::uint32_t> times,
                                                  Interference interference, EncodingLimit limit,
                                                  Progress& progress);

  [[nodiscard]] std::size_t n_levels() const { return first_.size() - 1; }
  [[nodiscard]] bool has_links() const { return !links_.empty(); }
  /// Of all levels, one list after the other.
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
  /// Of a level's list, or after the last one.
  [[nodiscard]] std::uint32_t first_entry(std::size_t level) const { return first_[level]; }
  [[nodiscard]] std::span<const std::uint32_t> links_of(std::uint32_t entry) const {
    const auto level = std::ranges::upper_bound(first_, entry) - first_.begin() - 1;
    const auto i = static_cast<std::size_t>(level);
    return links_[i].of(entry - first_[i]);
  }
  /// Gives those of each level's entries away, and has none then.
  [[nodiscard]] std::vector<LinkLists> take_links() { return std::exchange(links_, {}); }
  [[nodiscard]] std::uint64_t n_links() const;
  [[nodiscard]] std::uint64_t n_bytes() const;
  [[nodiscard]] delaunay::Tin extract(const History& history, std::size_t level) const;
  /// As CompletePyramid; an entry. It has links.
  [[nodiscard]] std::optional<std::uint32_t> locate(const History& history, std::size_t level,
                                                    delaunay::LatticePoint p) const;
  [[nodiscard]] std::vector<std::uint32_t> zoom(const History& history, std::size_t level,
                                                const Window& window) const;

 private:
  /// `numbers`: of the entries, in the history.
  Result<void> link(const History& history, std::span<const std::uint32_t> times,
                    const std::vector<std::uint32_t>& numbers, EncodingLimit limit,
                    Progress& progress);

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> first_;  ///< By level, and one more.
  std::vector<LinkLists> links_;      ///< By level; or none.
  std::optional<StartFinder> start_;  ///< Of the first list, where there are links.
};

}  // namespace lode::delaunay_pyramid
