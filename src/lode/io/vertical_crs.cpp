#include "lode/io/vertical_crs.h"

#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "lode/core/vertical_unit.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr const char* kEllipsoid = "ellipsoid";
constexpr const char* kEllipsoidalHeight = "ellipsoidal height";

std::string name_of(const Proj& proj, const PJ* crs) {
  const char* name = proj.library().name(crs);
  return name == nullptr ? "unnamed" : without_controls(name);
}

/// Of a CRS that is bound to another, by grids, itself.
Proj::Object unbound(const Proj& proj, const PJ* crs) {
  const ProjLibrary& library = proj.library();
  if (library.type(crs) == PJ_TYPE_BOUND_CRS)
    return proj.own(library.source_crs(proj.context(), crs));
  return proj.own(library.clone(proj.context(), crs));
}

bool is_vertical(const Proj& proj, const PJ* crs) {
  const Proj::Object itself = unbound(proj, crs);
  return itself && proj.library().type(itself.get()) == PJ_TYPE_VERTICAL_CRS;
}

/// The unit of an axis and whether it points down, or nothing where there are not so many.
bool read_axis(const Proj& proj, const PJ* crs, int axis, VerticalCrs& vertical) {
  const ProjLibrary& library = proj.library();
  const Proj::Object itself = unbound(proj, crs);
  if (!itself) return false;
  const Proj::Object system = proj.own(library.coordinate_system(proj.context(), itself.get()));
  if (!system || library.n_axes(proj.context(), system.get()) <= axis) return false;
  double metres = 0;
  const char* unit = nullptr;
  const char* direction = nullptr;
  if (library.axis_info(proj.context(), system.get(), axis, nullptr, nullptr, &direction, &metres,
                        &unit, nullptr, nullptr) == 0)
    return false;
  vertical.unit = unit == nullptr ? "" : without_controls(unit);
  vertical.metres = metres;
  vertical.is_depth = direction != nullptr && std::string_view(direction) == "down";
  return true;
}

Result<VerticalCrs> to_vertical(const Proj& proj, Proj::Object crs) {
  VerticalCrs vertical;
  vertical.name = name_of(proj, crs.get());
  if (!read_axis(proj, crs.get(), 0, vertical))
    return fail("expected the vertical CRS {} to have a unit, got none", vertical.name);
  vertical.crs = std::move(crs);
  return vertical;
}

bool is_same(const Proj& proj, const VerticalCrs& a, const VerticalCrs& b) {
  if (!a.crs || !b.crs) return !a.crs && !b.crs;
  return proj.library().is_equivalent(a.crs.get(), b.crs.get(), PJ_COMP_EQUIVALENT) != 0;
}

/// Whether a unit that a file names is another than that of its heights.
bool differs(const std::string& unit, const VerticalCrs& vertical) {
  const std::optional<double> metres = metres_of_unit(unit);
  constexpr double kSame = 1e-9;  // US survey feet and feet differ by 2e-6.
  return metres && std::abs(*metres / vertical.metres - 1) > kSame;
}

std::string text_of(const VerticalCrs& vertical) {
  return fmt::format("{} in {}", vertical.name, vertical.unit);
}

/// Takes the unit of the vertical CRS; what a file calls it stays.
void take_unit(const VerticalCrs& vertical, std::string& unit, std::vector<std::string>& notes) {
  const bool is_other = differs(unit, vertical);
  if (is_other)
    notes.push_back(
        fmt::format("its heights are said to be in {}; {} is taken", unit, text_of(vertical)));
  if (is_other || !metres_of_unit(unit)) unit = vertical.unit;
}

/// What a CRS says of heights, without PROJ's object, which goes with its context.
struct VerticalFacts {
  std::string name;
  bool is_depth = false;
};

std::optional<VerticalFacts> vertical_of(const std::string& crs) {
  if (!says_heights(crs)) return {};
  const auto proj = Proj::make();
  if (!proj) return {};
  const auto split = split_crs(*proj, crs);
  if (!split || !split->vertical) return {};
  return VerticalFacts{split->vertical->name, split->vertical->is_depth};
}

}  // namespace

Result<SplitCrs> split_crs(const Proj& proj, const std::string& wkt) {
  SplitCrs split;
  if (wkt.empty()) return split;
  const ProjLibrary& library = proj.library();
  Proj::Object crs = proj.own(library.create(proj.context(), wkt.c_str()));
  if (!crs) return fail("expected a CRS that PROJ knows, got {}", quoted(wkt));
  if (library.type(crs.get()) == PJ_TYPE_COMPOUND_CRS) {
    split.horizontal = proj.own(library.sub_crs(proj.context(), crs.get(), 0));
    Proj::Object second = proj.own(library.sub_crs(proj.context(), crs.get(), 1));
    if (second && name_of(proj, second.get()) == kEllipsoidalHeight) {
      split.vertical = VerticalCrs{.name = kEllipsoid};
    } else if (second && is_vertical(proj, second.get())) {
      LODE_TRY(split.vertical, to_vertical(proj, std::move(second)));
    }
    return split;
  }
  if (is_vertical(proj, crs.get())) {
    LODE_TRY(split.vertical, to_vertical(proj, std::move(crs)));
    return split;
  }
  VerticalCrs above_ellipsoid{.name = kEllipsoid};
  if (!read_axis(proj, crs.get(), 2, above_ellipsoid)) {
    split.horizontal = std::move(crs);
    return split;
  }
  split.horizontal = proj.own(library.without_height(proj.context(), nullptr, crs.get()));
  split.vertical = std::move(above_ellipsoid);
  return split;
}

Result<VerticalCrs> vertical_named(const Proj& proj, const std::string& text) {
  if (to_lower(text) == kEllipsoid) return VerticalCrs{.name = kEllipsoid};
  Proj::Object crs = proj.own(proj.library().create(proj.context(), text.c_str()));
  if (!crs)
    return fail("expected a vertical CRS as EPSG:N or WKT, or 'ellipsoid', got {}", quoted(text));
  if (!is_vertical(proj, crs.get()))
    return fail("expected a vertical CRS, such as EPSG:5773, or 'ellipsoid', got {}, which is {}",
                quoted(text), name_of(proj, crs.get()));
  return to_vertical(proj, std::move(crs));
}

Result<Proj::Object> joined(const Proj& proj, PJ* horizontal, const VerticalCrs& vertical) {
  const ProjLibrary& library = proj.library();
  if (horizontal == nullptr && !vertical.crs)
    return fail("expected a horizontal CRS, whose ellipsoid heights are above, got none");
  if (horizontal == nullptr) return proj.own(library.clone(proj.context(), vertical.crs.get()));
  Proj::Object whole;
  if (vertical.crs) {
    const std::string name = name_of(proj, horizontal) + " + " + vertical.name;
    whole =
        proj.own(library.compound(proj.context(), name.c_str(), horizontal, vertical.crs.get()));
  } else {
    whole = proj.own(library.with_height(proj.context(), nullptr, horizontal));
  }
  if (!whole)
    return fail("expected to put {} and {} together, got: {}", name_of(proj, horizontal),
                vertical.name, proj.reason());
  return whole;
}

Result<std::string> wkt_of(const Proj& proj, const PJ* crs) {
  const std::array<const char*, 2> options{"MULTILINE=NO", nullptr};
  for (const PJ_WKT_TYPE type : {PJ_WKT1_GDAL, PJ_WKT2_2019})
    if (const char* wkt = proj.library().as_wkt(proj.context(), crs, type, options.data());
        wkt != nullptr)
      return without_controls(wkt);
  return fail("expected a CRS that WKT can say, got {}", name_of(proj, crs));
}

Result<void> check_vertical(const VerticalOptions& options) {
  if (options.is_empty()) return {};
  LODE_TRY(const Proj proj, Proj::make());
  for (const std::string* text : {&options.declared, &options.target})
    if (!text->empty())
      if (auto named = vertical_named(proj, *text); !named) return named.error();
  return {};
}

Result<SplitCrs> declare_vertical(const Proj& proj, const std::string& declared,
                                  HeightReference& reference, std::vector<std::string>& notes) {
  LODE_TRY(SplitCrs split, split_crs(proj, reference.crs));
  if (declared.empty()) {
    if (split.vertical) take_unit(*split.vertical, reference.unit, notes);
    return split;
  }
  LODE_TRY(VerticalCrs vertical, vertical_named(proj, declared));
  if (split.vertical && !is_same(proj, *split.vertical, vertical))
    notes.push_back(fmt::format("its heights are said to be {}; {} is taken, as told",
                                text_of(*split.vertical), text_of(vertical)));
  take_unit(vertical, reference.unit, notes);
  LODE_TRY(const Proj::Object whole, joined(proj, split.horizontal.get(), vertical));
  if (split.horizontal) {
    LODE_TRY(reference.crs, wkt_of(proj, whole.get()));
  }
  split.vertical = std::move(vertical);
  return split;
}

bool says_heights(const std::string& crs) {
  for (const char* word : {"VERT_CS[", "VERTCRS[", "VERTICALCRS[", "ellipsoidal height"})
    if (crs.find(word) != std::string::npos) return true;
  return false;
}

std::string to_geotiff_crs(const std::string& crs) {
  if (!says_heights(crs)) return crs;
  const auto proj = Proj::make();
  if (!proj) return crs;
  const auto split = split_crs(*proj, crs);
  if (!split || !split->horizontal || !split->vertical || split->vertical->crs) return crs;
  const PJ_TYPE type = proj->library().type(unbound(*proj, split->horizontal.get()).get());
  if (type != PJ_TYPE_PROJECTED_CRS) return crs;
  VerticalCrs height{.name = kEllipsoidalHeight};
  const std::string wkt = fmt::format(
      R"(VERT_CS["{0}",VERT_DATUM["{0}",2005],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Up",UP]])",
      kEllipsoidalHeight);
  height.crs = proj->own(proj->library().create(proj->context(), wkt.c_str()));
  if (!height.crs) return crs;
  const auto whole = joined(*proj, split->horizontal.get(), height);
  const auto text = whole ? wkt_of(*proj, whole->get()) : Result<std::string>(whole.error());
  return text ? *text : crs;
}

std::string vertical_name(const std::string& crs) {
  const auto vertical = vertical_of(crs);
  return vertical ? vertical->name : std::string();
}

bool has_depths(const std::string& crs) {
  const auto vertical = vertical_of(crs);
  return vertical && vertical->is_depth;
}

}  // namespace lode::io
