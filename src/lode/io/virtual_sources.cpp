#include "lode/io/virtual_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include <pugixml.hpp>

#include "lode/io/ascii_grid.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/height_formats.h"
#include "lode/io/text.h"
#include "lode/io/virtual_raster.h"

namespace lode::io {
namespace {

constexpr const char* kAdvice =
    "a NoDataValue for samples without heights that the type has: gdalbuildvrt -vrtnodata writes "
    "one";

/// What a band of a file says of itself.
struct SourceFacts {
  int n_columns = 0;
  int n_rows = 0;
  int block_columns = 0;
  int block_rows = 0;
  GDALDataType type = GDT_Unknown;
  std::string type_name{};
  std::optional<double> nodata{};
  bool has_mask = false;
  bool is_signed_byte = false;
  bool needs_doubles = false;  ///< Text, whose numbers float32 does not hold.
  std::string unit{};
  double scale = 1;
  double offset = 0;
};

/// float32 rounds what a text says of it, in as many digits as its writer took.
bool is_same_number(double a, double b, GDALDataType type) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return true;
  if (type != GDT_Float32) return false;
  const double size = std::max(std::abs(a), std::abs(b));
  return std::abs(a - b) <= size * 0x1p-23;
}

class VirtualCheck {
 public:
  VirtualCheck(const std::string& path, const VirtualRaster& raster, const GdalLibrary& gdal)
      : path_(path), raster_(raster), gdal_(gdal) {}

  Result<CheckedVirtualRaster> run();

 private:
  Result<void> add_band(const VirtualBand& band, pugi::xml_node to, std::string& fault);
  void add_source(const VirtualSource& source, const SourceFacts& facts, pugi::xml_node to);
  Result<SourceFacts> look_at(const VirtualSource& source);
  Result<void> check_driver(const VirtualSource& source) const;
  Result<SourceFacts> facts_of(GDALDatasetH dataset, const VirtualSource& source) const;
  Result<void> check_source(const VirtualBand& band, const VirtualSource& source,
                            const SourceFacts& facts) const;
  [[nodiscard]] std::string fault_of(const VirtualBand& band, const VirtualSource& source,
                                     const SourceFacts& facts) const;
  [[nodiscard]] std::string gap_of(const VirtualBand& band) const;

  const std::string& path_;
  const VirtualRaster& raster_;
  const GdalLibrary& gdal_;
  CheckedVirtualRaster checked_;
  std::map<std::pair<std::string, int>, SourceFacts> known_;
  std::map<std::string, std::uint64_t> sizes_;
};

void add_text(pugi::xml_node to, const char* name, const std::string& text) {
  if (!text.empty()) to.append_child(name).text().set(text.c_str());
}

/// As GDAL reads it back to the same number.
std::string as_text(double number) { return fmt::format("{:.17g}", number); }

void add_part(pugi::xml_node to, const char* name, const VirtualPart& part) {
  pugi::xml_node node = to.append_child(name);
  const auto add = [&](const char* attribute, double number) {
    node.append_attribute(attribute).set_value(as_text(number).c_str());
  };
  add("xOff", part.left);
  add("yOff", part.top);
  add("xSize", part.right - part.left);
  add("ySize", part.bottom - part.top);
}

Result<CheckedVirtualRaster> VirtualCheck::run() {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("VRTDataset");
  root.append_attribute("rasterXSize").set_value(raster_.n_columns);
  root.append_attribute("rasterYSize").set_value(raster_.n_rows);
  add_text(root, "SRS", raster_.crs);
  if (pugi::xml_node crs = root.child("SRS"); crs && !raster_.axes.empty())
    crs.append_attribute("dataAxisToSRSAxisMapping").set_value(raster_.axes.c_str());
  add_text(root, "GeoTransform", raster_.geotransform);
  if (raster_.is_of_points) {
    pugi::xml_node item = root.append_child("Metadata").append_child("MDI");
    item.append_attribute("key").set_value("AREA_OR_POINT");
    item.text().set("Point");
  }
  for (const VirtualBand& band : raster_.bands) {
    pugi::xml_node node = root.append_child("VRTRasterBand");
    node.append_attribute("band").set_value(static_cast<int>(checked_.faults.size()) + 1);
    LODE_CHECK(add_band(band, node, checked_.faults.emplace_back()));
  }
  if (raster_.mask) {
    std::string fault;
    LODE_CHECK(add_band(*raster_.mask, root.append_child("MaskBand").append_child("VRTRasterBand"),
                        fault));
  }
  std::ostringstream text;
  document.save(text, "", pugi::format_raw | pugi::format_no_declaration);
  checked_.text = text.str();
  for (const auto& [name, n_bytes] : sizes_) checked_.n_bytes += n_bytes;
  return std::move(checked_);
}

Result<void> VirtualCheck::add_band(const VirtualBand& band, pugi::xml_node to,
                                    std::string& fault) {
  to.append_attribute("dataType").set_value(band.type.c_str());
  if (band.nodata) add_text(to, "NoDataValue", as_text(*band.nodata));
  if (band.is_opacity) add_text(to, "ColorInterp", "Alpha");
  if (band.scale != 1) add_text(to, "Scale", as_text(band.scale));
  if (band.offset != 0) add_text(to, "Offset", as_text(band.offset));
  if (!band.is_opacity) fault = gap_of(band);
  std::optional<std::string> unit;
  for (const VirtualSource& source : band.sources) {
    LODE_TRY(const SourceFacts facts, look_at(source));
    LODE_CHECK(check_source(band, source, facts));
    if (fault.empty() && !band.is_opacity) fault = fault_of(band, source, facts);
    if (!unit) unit = facts.unit;
    if (band.unit.empty() && *unit != facts.unit)
      return fail("{}: expected files of one unit, got {} in {} and {} in another", path_,
                  quoted(facts.unit), quoted(source.path), quoted(*unit));
    add_source(source, facts, to);
  }
  add_text(to, "UnitType", band.unit.empty() ? unit.value_or("") : band.unit);
  return {};
}

void VirtualCheck::add_source(const VirtualSource& source, const SourceFacts& facts,
                              pugi::xml_node to) {
  pugi::xml_node node = to.append_child(source.is_plain() ? "SimpleSource" : "ComplexSource");
  if (!source.resampling.empty())
    node.append_attribute("resampling").set_value(source.resampling.c_str());
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(source.path, ignored);
  pugi::xml_node file = node.append_child("SourceFilename");
  file.append_attribute("relativeToVRT").set_value(0);
  file.append_attribute("shared").set_value(0);
  file.text().set(whole.c_str());
  add_text(node, "SourceBand", fmt::format("{}{}", source.is_of_mask ? "mask," : "", source.band));
  pugi::xml_node properties = node.append_child("SourceProperties");
  properties.append_attribute("RasterXSize").set_value(facts.n_columns);
  properties.append_attribute("RasterYSize").set_value(facts.n_rows);
  properties.append_attribute("DataType").set_value(facts.type_name.c_str());
  properties.append_attribute("BlockXSize").set_value(facts.block_columns);
  properties.append_attribute("BlockYSize").set_value(facts.block_rows);
  if (source.from) add_part(node, "SrcRect", *source.from);
  if (source.part) add_part(node, "DstRect", *source.part);
  if (source.nodata) add_text(node, "NODATA", as_text(*source.nodata));
  if (source.uses_mask) add_text(node, "UseMaskBand", "true");
  if (source.scale != 1 || source.offset != 0) {
    add_text(node, "ScaleOffset", as_text(source.offset));
    add_text(node, "ScaleRatio", as_text(source.scale));
  }
}

std::string VirtualCheck::gap_of(const VirtualBand& band) const {
  if (band.nodata) return {};
  const std::uint64_t n = uncovered_samples(raster_, band);
  if (n == 0 && !band.has_odd_nodata) return {};
  if (n == 0) return fmt::format("expected {}, got one that {} has not", kAdvice, band.type);
  return fmt::format("expected {}, got none; {} of {} x {} samples are in none of its {} files",
                     kAdvice, n, raster_.n_columns, raster_.n_rows, band.sources.size());
}

/// Whether what a file has for missing samples would become heights.
std::string VirtualCheck::fault_of(const VirtualBand& band, const VirtualSource& source,
                                   const SourceFacts& facts) const {
  if (source.is_of_mask) return {};
  const bool leaves_out = source.nodata || source.uses_mask;
  if (leaves_out && !band.nodata)
    return fmt::format("expected {}, got none; some of {} are left out", kAdvice,
                       quoted(source.path));
  if (source.uses_mask) return {};
  if (facts.has_mask)
    return fmt::format("expected a mask, as its part {} has one, got none", quoted(source.path));
  if (!facts.nodata) return {};
  const bool stays = source.scale == 1 && source.offset == 0;
  const std::optional<double> left_out = source.nodata ? source.nodata
                                         : stays       ? band.nodata
                                                       : std::nullopt;
  if (left_out && is_same_number(*facts.nodata, *left_out, facts.type)) return {};
  return fmt::format(
      "expected samples of {} to be none, which its part {} has for missing ones, "
      "and which would become heights",
      *facts.nodata, quoted(source.path));
}

/// What the mosaic must say as its files do.
Result<void> VirtualCheck::check_source(const VirtualBand& band, const VirtualSource& source,
                                        const SourceFacts& facts) const {
  if (source.is_of_mask) return {};
  const bool is_as_file = facts.scale == band.scale && facts.offset == band.offset;
  if (!is_as_file)
    return fail("{}: expected the Scale {} and Offset {} of its part {}, got {} and {}", path_,
                facts.scale, facts.offset, quoted(source.path), band.scale, band.offset);
  if (facts.is_signed_byte)
    return fail(
        "{}: expected parts of types that a VRT has, got signed bytes in {}: "
        "gdal_translate makes a GeoTIFF of them",
        path_, quoted(source.path));
  if (facts.needs_doubles && band.type != "Float64")
    return fail("{}: expected Float64 for the numbers of its part {}, got {}", path_,
                quoted(source.path), band.type);
  return {};
}

Result<SourceFacts> VirtualCheck::look_at(const VirtualSource& source) {
  const auto key = std::pair(source.path, source.band);
  if (const auto found = known_.find(key); found == known_.end()) {
    std::error_code status;
    if (!std::filesystem::is_regular_file(source.path, status))
      return fail("{}: expected its part {}, got no such file", path_, quoted(source.path));
    if (is_virtual_raster(source.path))
      return fail(
          "{}: expected parts that are no VRT themselves, got {}: put the files of all "
          "together",
          path_, quoted(source.path));
    if (const auto kind = check_raster_kind(source.path); !kind)
      return fail("{}: part {}", path_, kind.error().message);
    LODE_CHECK(check_driver(source));
    GDALDatasetH dataset = gdal_.open(source.path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                      part_drivers().data(), nullptr, nullptr);
    if (dataset == nullptr) {
      const std::string reason = without_controls(gdal_.last_error());
      return fail("{}: expected its part {} to be {}, got: {}", path_, quoted(source.path),
                  kRasterFormats, reason.empty() ? "nothing that it knows" : reason);
    }
    auto facts = facts_of(dataset, source);
    gdal_.close(dataset);
    if (!facts) return facts.error();
    sizes_[std::filesystem::weakly_canonical(source.path, status).string()] =
        std::filesystem::file_size(source.path, status);
    checked_.n_block_rows = std::max(checked_.n_block_rows, facts->block_rows);
    known_.emplace(key, std::move(*facts));
  }
  const SourceFacts& facts = known_.at(key);
  constexpr double kRounding = 1e-3;
  if (const auto& from = source.from; from && (from->left < -kRounding || from->top < -kRounding ||
                                               from->right > facts.n_columns + kRounding ||
                                               from->bottom > facts.n_rows + kRounding))
    return fail(
        "{}: expected a SrcRect inside of the {} x {} samples of {}, got {} x {} from {}, "
        "{}",
        path_, facts.n_columns, facts.n_rows, quoted(source.path), from->right - from->left,
        from->bottom - from->top, from->left, from->top);
  return facts;
}

/// That GDAL, which asks all its drivers of a part, takes it for what it is.
Result<void> VirtualCheck::check_driver(const VirtualSource& source) const {
  gdal_.reset_errors();
  GDALDriverH driver = gdal_.identify(source.path.c_str(), GDAL_OF_RASTER, nullptr, nullptr);
  if (driver == nullptr) return {};
  const std::string_view name = gdal_.driver_name(driver);
  const auto drivers = part_drivers();
  for (const char* const allowed : drivers)
    if (allowed != nullptr && name == allowed) return {};
  return fail("{}: expected its part {} to be {}, got {}", path_, quoted(source.path),
              kRasterFormats, name);
}

Result<SourceFacts> VirtualCheck::facts_of(GDALDatasetH dataset,
                                           const VirtualSource& source) const {
  const int n_bands = gdal_.n_bands(dataset);
  if (source.band > n_bands)
    return fail("{}: expected its part {} to have a band {}, got {} of them", path_,
                quoted(source.path), source.band, n_bands);
  GDALRasterBandH band = gdal_.band(dataset, source.band);
  SourceFacts facts;
  facts.n_columns = gdal_.n_columns(dataset);
  facts.n_rows = gdal_.n_rows(dataset);
  gdal_.block_size(band, &facts.block_columns, &facts.block_rows);
  facts.type = gdal_.type(band);
  facts.type_name = gdal_.type_name(facts.type);
  int has_nodata = 0;
  const double nodata = gdal_.nodata(band, &has_nodata);
  if (has_nodata != 0) facts.nodata = nodata;
  facts.has_mask = (gdal_.mask_flags(band) & (GMF_PER_DATASET | GMF_ALPHA)) != 0;
  const char* pixels = gdal_.metadata(band, "PIXELTYPE", "IMAGE_STRUCTURE");
  facts.is_signed_byte = pixels != nullptr && std::string_view(pixels) == "SIGNEDBYTE";
  facts.needs_doubles = ascii_grid_type(source.path) == "Float64";
  const char* unit = gdal_.unit(band);
  facts.unit = unit == nullptr ? std::string() : without_controls(unit);
  facts.scale = gdal_.scale(band, nullptr);
  facts.offset = gdal_.offset(band, nullptr);
  return facts;
}

}  // namespace

Result<CheckedVirtualRaster> check_virtual_raster(const std::string& path,
                                                  const GdalLibrary& gdal) {
  LODE_TRY(const VirtualRaster raster, read_virtual_raster(path));
  return VirtualCheck(path, raster, gdal).run();
}

}  // namespace lode::io
