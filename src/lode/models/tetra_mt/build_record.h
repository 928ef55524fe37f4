#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/collapse_order.h"
#include "lode/models/tetra_mt/refusals.h"
#include "lode/store/bytes.h"

namespace lode::tetra_mt {

/// What a build was told and what came of it, for whoever is given its file: no answer but those of
/// attached fields of midpoints, whose collapses are done again, depends on it.
struct BuildRecord {
  using Count = std::pair<std::string, std::uint64_t>;
  using Note = std::pair<std::string, std::string>;
  static constexpr std::uint32_t kMaxCounts = 256;
  static constexpr std::uint32_t kMaxNotes = 1U << 14;

  CollapseOrder order = CollapseOrder::squared_error;
  bool keeps_extrema = false;     ///< Those of the reference.
  double boundary_tolerance = 0;  ///< The mesh's unit.
  double volume_change = 0;       ///< The base's volume less the reference's; any number.
  /// Vertices of the base by the rule that keeps them there, where there are any: named().
  std::vector<Count> refusals{};
  /// What was counted when the mesh was read, and what was said of its arrays, by whoever did;
  /// names are labels, and texts.
  std::vector<Count> reading{};
  std::vector<Note> notes{};

  friend bool operator==(const BuildRecord&, const BuildRecord&) = default;
};

/// By "non-manifold", "extremum", ..., those above 0.
[[nodiscard]] std::vector<BuildRecord::Count> named(const RefusalCounts& counts);

/// Of metadata, docs/format.md, section 7. A name or text that is no label becomes one,
/// and what is more than a file may have is left out.
void write_record(const BuildRecord& record, store::ByteWriter& out);
[[nodiscard]] Result<BuildRecord> read_record(store::ByteReader& in, const std::string& path);

}  // namespace lode::tetra_mt
