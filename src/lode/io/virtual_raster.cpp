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

#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;
constexpr const char* kRoot = "VRTDataset";

/// Rasters of floats may have no number for missing ones.
std::optional<double> nodata_of(std::string_view text) {
  if (to_lower(text) == "nan") return std::numeric_limits<double>::quiet_NaN();
  return to_double(text);
}

/// What is read of a file, with its name for messages.
class VirtualReader {
 public:
  VirtualReader(const std::string& path, VirtualRaster& raster) : path_(path), raster_(raster) {}

  Result<void> run(const pugi::xml_node& root);

 private:
  Result<void> add_band(const pugi::xml_node& node);
  Result<VirtualSource> source_of(const pugi::xml_node& node) const;
  Result<std::optional<VirtualPart>> part_of(const pugi::xml_node& node) const;
  [[nodiscard]] Result<void> check_class(const pugi::xml_node& node, std::string_view usual) const;

  const std::string& path_;
  VirtualRaster& raster_;
};

Result<void> VirtualReader::check_class(const pugi::xml_node& node, std::string_view usual) const {
  const std::string_view kind = node.attribute("subClass").value();
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
  for (const pugi::xml_node& node : root.children("VRTRasterBand")) LODE_CHECK(add_band(node));
  if (const pugi::xml_node mask = root.child("MaskBand")) {
    raster_.has_mask = true;
    for (const pugi::xml_node& node : mask.children("VRTRasterBand")) {
      LODE_CHECK(add_band(node));
      raster_.bands.back().is_opacity = true;
    }
  }
  return {};
}

Result<void> VirtualReader::add_band(const pugi::xml_node& node) {
  LODE_CHECK(check_class(node, "VRTSourcedRasterBand"));
  VirtualBand band;
  band.number = node.attribute("band").as_int(static_cast<int>(raster_.bands.size()) + 1);
  band.is_opacity = std::string_view(node.child("ColorInterp").text().get()) == "Alpha";
  raster_.has_mask = raster_.has_mask || band.is_opacity;
  for (const pugi::xml_node& child : node.children()) {
    const std::string_view name = child.name();
    if (name == "NoDataValue" && !node.child("HideNoDataValue").text().as_bool())
      band.nodata = nodata_of(trimmed(child.text().get()));
    if (name == "MaskBand") raster_.has_mask = true;
    if (!name.ends_with("Source")) continue;
    if (name != "SimpleSource" && name != "ComplexSource" && name != "AveragedSource")
      return fail(
          "{}: expected bands of parts of files, got a {}: gdal_translate makes a GeoTIFF "
          "of it",
          path_, quoted(name));
    LODE_TRY(VirtualSource source, source_of(child));
    band.sources.push_back(std::move(source));
  }
  raster_.bands.push_back(std::move(band));
  return {};
}

Result<VirtualSource> VirtualReader::source_of(const pugi::xml_node& node) const {
  VirtualSource source;
  const pugi::xml_node file = node.child("SourceFilename");
  const std::string name = file.text().get();
  if (name.empty() || name.starts_with("/vsi") || name.starts_with("<"))
    return fail("{}: expected parts of files, got {}", path_, quoted(name));
  const bool is_beside = file.attribute("relativeToVRT").as_int() != 0;
  source.path = is_beside ? (std::filesystem::path(path_).parent_path() / name).string() : name;
  const std::string_view band = node.child("SourceBand").text().get();
  source.band = band.starts_with("mask") ? 0 : node.child("SourceBand").text().as_int(1);
  source.is_copied = !node.child("NODATA") && !node.child("UseMaskBand").text().as_bool();
  LODE_TRY(source.from, part_of(node.child("SrcRect")));
  LODE_TRY(source.part, part_of(node.child("DstRect")));
  return source;
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
  return std::optional(
      VirtualPart{numbers[0], numbers[1], numbers[0] + numbers[2], numbers[1] + numbers[3]});
}

/// How much of a line is covered by intervals that come and go, between given places.
class CoveredLine {
 public:
  explicit CoveredLine(std::vector<double> places) : places_(std::move(places)) {
    std::ranges::sort(places_);
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    nodes_.resize(4 * places_.size());
  }
  /// `by`: 1 or -1; both ends are places.
  void add(double from, double to, int by) {
    if (from < to) add({1, 0, places_.size() - 1}, place_of(from), place_of(to), by);
  }
  [[nodiscard]] double length() const { return nodes_[1].length; }

 private:
  struct Node {
    int n = 0;  ///< Intervals that cover all of it.
    double length = 0;
  };
  struct Range {
    std::size_t node;
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] std::size_t place_of(double at) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(places_, at) - places_.begin());
  }
  void add(const Range& range, std::size_t from, std::size_t to, int by) {
    if (to <= range.first || range.last <= from) return;
    Node& node = nodes_[range.node];
    const bool is_leaf = range.last - range.first == 1;
    if (from <= range.first && range.last <= to) {
      node.n += by;
    } else {
      const std::size_t middle = (range.first + range.last) / 2;
      add({2 * range.node, range.first, middle}, from, to, by);
      add({2 * range.node + 1, middle, range.last}, from, to, by);
    }
    if (node.n > 0)
      node.length = places_[range.last] - places_[range.first];
    else
      node.length = is_leaf ? 0 : nodes_[2 * range.node].length + nodes_[2 * range.node + 1].length;
  }

  std::vector<double> places_;
  std::vector<Node> nodes_;
};

/// The area of what rectangles cover, of a line that sweeps over them.
double covered_area(const std::vector<VirtualPart>& parts) {
  struct Event {
    double y;
    double left;
    double right;
    int by;
  };
  std::vector<Event> events;
  std::vector<double> places;
  events.reserve(2 * parts.size());
  places.reserve(2 * parts.size());
  for (const VirtualPart& part : parts) {
    events.push_back({part.top, part.left, part.right, 1});
    events.push_back({part.bottom, part.left, part.right, -1});
    places.push_back(part.left);
    places.push_back(part.right);
  }
  if (events.empty()) return 0;
  std::ranges::sort(events, {}, &Event::y);
  CoveredLine line(std::move(places));
  double area = 0;
  double last = events.front().y;
  for (const Event& event : events) {
    area += line.length() * (event.y - last);
    last = event.y;
    line.add(event.left, event.right, event.by);
  }
  return area;
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
  LODE_CHECK(VirtualReader(path, raster).run(root));
  if (raster.bands.empty()) return fail("{}: expected a VRT with bands, got none", path);
  return raster;
}

double uncovered_samples(const VirtualRaster& raster, const VirtualBand& band) {
  const double columns = raster.n_columns;
  const double rows = raster.n_rows;
  std::vector<VirtualPart> parts;
  for (const VirtualSource& source : band.sources) {
    if (!source.part) return 0;
    const VirtualPart part{
        std::clamp(source.part->left, 0.0, columns), std::clamp(source.part->top, 0.0, rows),
        std::clamp(source.part->right, 0.0, columns), std::clamp(source.part->bottom, 0.0, rows)};
    if (part.left < part.right && part.top < part.bottom) parts.push_back(part);
  }
  return std::floor(columns * rows - covered_area(parts) + 0.5);
}

}  // namespace lode::io
