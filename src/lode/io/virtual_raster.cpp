#include "lode/io/virtual_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <pugixml.hpp>
#include <system_error>
#include <utility>

#include "lode/io/covered_area.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;
constexpr const char* kRoot = "VRTDataset";

/// What elements of a band and a source mean here; others are left out.
constexpr std::array<std::string_view, 3> kSources{"SimpleSource", "ComplexSource",
                                                   "AveragedSource"};
constexpr std::array<const char*, 9> kRefused{
    "LUT",    "Exponent", "SrcMin",      "SrcMax",
    "DstMin", "DstMax",   "OpenOptions", "ColorTableComponent",
    "Kernel"};

std::string text_of(const pugi::xml_node& node) { return std::string(trimmed(node.text().get())); }

/// "nan" stands for what is no number.
std::optional<double> number_of(std::string_view text) {
  if (to_lower(text) == "nan") return std::numeric_limits<double>::quiet_NaN();
  return to_double(text);
}

/// Whether a number is one of GDAL's type, of reals.
bool is_of_type(double number, std::string_view type) {
  struct Whole {
    std::string_view type;
    double low;
    double high;
  };
  constexpr std::array<Whole, 8> kWhole{{{"Byte", 0, 255},
                                         {"Int8", -128, 127},
                                         {"UInt16", 0, 65535},
                                         {"Int16", -32768, 32767},
                                         {"UInt32", 0, 4294967295.0},
                                         {"Int32", -2147483648.0, 2147483647.0},
                                         {"UInt64", 0, 0x1p63},
                                         {"Int64", -0x1p63, 0x1p62}}};
  const auto* const whole = std::ranges::find(kWhole, type, &Whole::type);
  if (whole == kWhole.end()) return true;
  return number == std::floor(number) && number >= whole->low && number <= whole->high;
}

/// What is read of a file, with its name for messages.
class VirtualReader {
 public:
  VirtualReader(const std::string& path, std::string directory, VirtualRaster& raster)
      : path_(path), directory_(std::move(directory)), raster_(raster) {}

  Result<void> run(const pugi::xml_node& root);

 private:
  Result<VirtualBand> band_of(const pugi::xml_node& node) const;
  Result<VirtualSource> source_of(const pugi::xml_node& node) const;
  Result<void> add_file(const pugi::xml_node& node, VirtualSource& source) const;
  Result<std::optional<VirtualPart>> part_of(const pugi::xml_node& node) const;
  Result<double> number_at(const pugi::xml_node& node, const char* name, double otherwise) const;
  [[nodiscard]] Result<void> check_class(const pugi::xml_node& node, std::string_view usual) const;

  const std::string& path_;
  std::string directory_;
  VirtualRaster& raster_;
};

/// GDAL takes names in any case, and attributes as elements, too.
Result<void> VirtualReader::check_class(const pugi::xml_node& node, std::string_view usual) const {
  std::string kind;
  for (const pugi::xml_attribute& attribute : node.attributes())
    if (to_lower(attribute.name()) == "subclass") kind = attribute.value();
  for (const pugi::xml_node& child : node.children())
    if (to_lower(child.name()) == "subclass") kind = text_of(child);
  if (kind.empty() || kind == usual) return {};
  return fail(
      "{}: expected a VRT whose bands are put together from files, got a {}: "
      "gdal_translate makes a GeoTIFF of it",
      path_, quoted(kind));
}

Result<void> VirtualReader::run(const pugi::xml_node& root) {
  LODE_CHECK(check_class(root, kRoot));
  const auto side = [&](const char* name) {
    const long long n = root.attribute(name).as_llong();
    return n > 0 && n <= std::numeric_limits<std::int32_t>::max() ? static_cast<std::int32_t>(n)
                                                                  : 0;
  };
  raster_.n_columns = side("rasterXSize");
  raster_.n_rows = side("rasterYSize");
  if (raster_.n_columns == 0 || raster_.n_rows == 0)
    return fail("{}: expected a rasterXSize and rasterYSize above 0, got {} and {}", path_,
                quoted(root.attribute("rasterXSize").value()),
                quoted(root.attribute("rasterYSize").value()));
  raster_.crs = text_of(root.child("SRS"));
  raster_.axes = root.child("SRS").attribute("dataAxisToSRSAxisMapping").value();
  raster_.geotransform = text_of(root.child("GeoTransform"));
  for (const pugi::xml_node& metadata : root.children("Metadata"))
    for (const pugi::xml_node& item : metadata.children("MDI"))
      if (std::string_view(item.attribute("key").value()) == "AREA_OR_POINT")
        raster_.is_of_points = text_of(item) == "Point";
  for (const pugi::xml_node& node : root.children("VRTRasterBand")) {
    LODE_TRY(VirtualBand band, band_of(node));
    raster_.bands.push_back(std::move(band));
  }
  if (const pugi::xml_node mask = root.child("MaskBand").child("VRTRasterBand")) {
    LODE_TRY(raster_.mask, band_of(mask));
  }
  return {};
}

Result<double> VirtualReader::number_at(const pugi::xml_node& node, const char* name,
                                        double otherwise) const {
  const pugi::xml_node child = node.child(name);
  if (!child) return otherwise;
  const auto number = to_double(text_of(child));
  if (number && std::isfinite(*number)) return *number;
  return fail("{}: expected a number for {}, got {}", path_, name, quoted(text_of(child)));
}

Result<VirtualBand> VirtualReader::band_of(const pugi::xml_node& node) const {
  LODE_CHECK(check_class(node, "VRTSourcedRasterBand"));
  VirtualBand band;
  band.type = node.attribute("dataType").as_string("Byte");
  band.is_opacity = text_of(node.child("ColorInterp")) == "Alpha";
  band.unit = text_of(node.child("UnitType"));
  LODE_TRY(band.scale, number_at(node, "Scale", 1));
  LODE_TRY(band.offset, number_at(node, "Offset", 0));
  if (const pugi::xml_node nodata = node.child("NoDataValue");
      nodata && !node.child("HideNoDataValue").text().as_bool()) {
    band.nodata = number_of(text_of(nodata));
    if (!band.nodata)
      return fail("{}: expected a number for NoDataValue, got {}", path_, quoted(text_of(nodata)));
    band.has_odd_nodata = !is_of_type(*band.nodata, band.type);
    if (band.has_odd_nodata) band.nodata.reset();
  }
  for (const pugi::xml_node& child : node.children()) {
    const std::string_view name = child.name();
    if (to_lower(name) == "maskband")
      return fail("{}: expected a mask of all bands, got one of a band", path_);
    if (!to_lower(name).ends_with("source")) continue;
    if (std::ranges::find(kSources, name) == kSources.end())
      return fail(
          "{}: expected bands of parts of files, got a {}: gdal_translate makes a GeoTIFF "
          "of it",
          path_, quoted(name));
    LODE_TRY(VirtualSource source, source_of(child));
    band.sources.push_back(std::move(source));
  }
  return band;
}

Result<VirtualSource> VirtualReader::source_of(const pugi::xml_node& node) const {
  VirtualSource source;
  LODE_CHECK(add_file(node, source));
  for (const char* const name : kRefused)
    if (node.child(name))
      return fail(
          "{}: expected the heights of {} as they are, or scaled, got {}: gdal_translate "
          "makes a GeoTIFF of it",
          path_, quoted(source.path), name);
  source.resampling = node.attribute("resampling").value();
  source.uses_mask = node.child("UseMaskBand").text().as_bool();
  if (const pugi::xml_node nodata = node.child("NODATA")) {
    source.nodata = number_of(text_of(nodata));
    if (!source.nodata)
      return fail("{}: expected a number for NODATA, got {}", path_, quoted(text_of(nodata)));
  }
  LODE_TRY(source.scale, number_at(node, "ScaleRatio", 1));
  LODE_TRY(source.offset, number_at(node, "ScaleOffset", 0));
  LODE_TRY(source.from, part_of(node.child("SrcRect")));
  LODE_TRY(source.part, part_of(node.child("DstRect")));
  return source;
}

Result<void> VirtualReader::add_file(const pugi::xml_node& node, VirtualSource& source) const {
  const pugi::xml_node file = node.child("SourceFilename");
  const std::string name = text_of(file);
  if (name.empty() || name.starts_with("/vsi") || name.starts_with("<"))
    return fail("{}: expected parts of files, got {}", path_, quoted(name));
  const bool is_beside = file.attribute("relativeToVRT").as_int() != 0;
  source.path = is_beside ? (std::filesystem::path(directory_) / name).string() : name;
  std::string band = text_of(node.child("SourceBand"));
  source.is_of_mask = band.starts_with("mask");
  if (source.is_of_mask) band.erase(0, band.starts_with("mask,") ? 5 : 4);
  const auto number = band.empty() ? std::optional<std::int64_t>(1) : to_int64(band);
  if (!number || *number < 1 || *number > std::numeric_limits<int>::max())
    return fail("{}: expected a SourceBand from 1, got {}", path_, quoted(band));
  source.band = static_cast<int>(*number);
  return {};
}

Result<std::optional<VirtualPart>> VirtualReader::part_of(const pugi::xml_node& node) const {
  if (!node) return std::optional<VirtualPart>();
  std::array<double, 4> numbers{};
  constexpr std::array<const char*, 4> kNames{"xOff", "yOff", "xSize", "ySize"};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto number = to_double(trimmed(node.attribute(kNames[i]).value()));
    if (!number || !std::isfinite(*number))
      return fail("{}: expected a number for {} of a {}, got {}", path_, kNames[i], node.name(),
                  quoted(node.attribute(kNames[i]).value()));
    numbers[i] = *number;
  }
  if (numbers == std::array<double, 4>{-1, -1, -1, -1}) return std::optional<VirtualPart>();
  return std::optional(
      VirtualPart{numbers[0], numbers[1], numbers[0] + numbers[2], numbers[1] + numbers[3]});
}

}  // namespace

bool is_virtual_raster(const std::string& path) {
  if (to_lower(path).ends_with(".vrt")) return true;
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) return false;
  std::string head(256, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head.find(std::string("<") + kRoot) != std::string::npos;
}

Result<VirtualRaster> read_virtual_raster(const std::string& path) {
  std::error_code status;
  const std::uintmax_t n_bytes = std::filesystem::file_size(path, status);
  if (!status && n_bytes > kMaxBytes)
    return fail("{}: expected a VRT of up to {}, got {}", path, format_bytes(kMaxBytes),
                format_bytes(n_bytes));
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_file(path.c_str(), pugi::parse_default);
  const pugi::xml_node root = document.child(kRoot);
  if (!parsed || !root)
    return fail("{}: expected a VRT, of XML with a {}, got: {}, at byte {}", path, kRoot,
                parsed ? "none" : parsed.description(), parsed.offset);
  VirtualRaster raster;
  // Names are beside the file itself, where the path is a link to it.
  std::error_code ignored;
  const std::filesystem::path real = std::filesystem::canonical(path, ignored);
  const std::filesystem::path place = ignored ? std::filesystem::path(path) : real;
  LODE_CHECK(VirtualReader(path, place.parent_path().string(), raster).run(root));
  if (raster.bands.empty()) return fail("{}: expected a VRT with bands, got none", path);
  return raster;
}

std::uint64_t uncovered_samples(const VirtualRaster& raster, const VirtualBand& band) {
  constexpr double kRounding = 1e-3;
  const double columns = raster.n_columns;
  const double rows = raster.n_rows;
  std::vector<Rectangle> parts;
  for (const VirtualSource& source : band.sources) {
    if (!source.part) return 0;
    const Rectangle part{std::clamp(std::floor(source.part->left + kRounding), 0.0, columns),
                         std::clamp(std::floor(source.part->top + kRounding), 0.0, rows),
                         std::clamp(std::ceil(source.part->right - kRounding), 0.0, columns),
                         std::clamp(std::ceil(source.part->bottom - kRounding), 0.0, rows)};
    if (part.left < part.right && part.top < part.bottom) parts.push_back(part);
  }
  return static_cast<std::uint64_t>(columns * rows - covered_area(parts));
}

}  // namespace lode::io
