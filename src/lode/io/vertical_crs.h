#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/proj_library.h"
#include "lode/io/vertical_options.h"

namespace lode::io {

/// What heights are above.
struct VerticalCrs {
  Proj::Object crs{};  ///< Null: the ellipsoid of the horizontal CRS.
  std::string name;
  std::string unit = "metre";
  double metres = 1;      ///< Of the unit.
  bool is_depth = false;  ///< It grows downwards.
};

/// A CRS in its two parts.
struct SplitCrs {
  Proj::Object horizontal;              ///< Null: not known.
  std::optional<VerticalCrs> vertical;  ///< Nothing: not known.
};

/// Of a CRS as WKT: compound, with ellipsoidal heights, horizontal, vertical, or empty. Fails on
/// what PROJ does not take.
[[nodiscard]] Result<SplitCrs> split_crs(const Proj& proj, const std::string& wkt);

/// As VerticalOptions have them. Fails on a CRS that is not vertical.
[[nodiscard]] Result<VerticalCrs> vertical_named(const Proj& proj, const std::string& text);

/// Both parts in one CRS; the vertical one alone where the other is not known. Fails where these
/// cannot be put together.
[[nodiscard]] Result<Proj::Object> joined(const Proj& proj, PJ* horizontal,
                                          const VerticalCrs& vertical);

/// WKT: of 2019 where the first version cannot say it. Fails where that cannot either.
[[nodiscard]] Result<std::string> wkt_of(const Proj& proj, const PJ* crs);

/// Fails on options that mean nothing; to be asked before files are read.
[[nodiscard]] Result<void> check_vertical(const VerticalOptions& options);

/// What a file says of its coordinates.
struct HeightReference {
  std::string crs;   ///< As WKT; empty: not known.
  std::string unit;  ///< Of heights; empty: not known.
};

/// Reconciles what a file says of its heights with what is declared (empty: nothing is):
/// `reference` gets the unit of its vertical CRS, or unit and CRS of what is declared, and notes
/// say where they contradict it. Of a file without a CRS only the unit can be kept. Returns both
/// parts, the vertical one as declared.
[[nodiscard]] Result<SplitCrs> declare_vertical(const Proj& proj, const std::string& declared,
                                                HeightReference& reference,
                                                std::vector<std::string>& notes);

/// Whether a CRS, as WKT or empty, says what heights are above; PROJ is not asked.
[[nodiscard]] bool says_heights(const std::string& crs);
}  // namespace lode::io
