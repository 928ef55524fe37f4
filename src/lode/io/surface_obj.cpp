#include "lode/io/surface_obj.h"

#include <fmt/compile.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>

#include "lode/io/surface_input.h"
#include "lode/io/surface_output.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// The comment that digits are those of doubles.
constexpr std::string_view kPlacesNote = "lode_places";
constexpr std::uint32_t kNoNormal = ~std::uint32_t{0};

/// Writes n lines of text, appended by add(i, text), in large pieces.
template <typename Add>
Result<void> write_lines(SurfaceOutput& file, std::size_t n, const Add& add) {
  constexpr std::size_t kPieceBytes = std::size_t{2} << 20;
  constexpr std::size_t kMaxLineBytes = 128;
  fmt::memory_buffer text;
  text.reserve(kPieceBytes + kMaxLineBytes);
  for (std::size_t i = 0; i < n; ++i) {
    add(i, std::back_inserter(text));
    if (text.size() < kPieceBytes) continue;
    LODE_CHECK(file.write(std::string_view(text.data(), text.size())));
    text.clear();
  }
  return file.write(std::string_view(text.data(), text.size()));
}

/// A guess: how long a line is depends on its digits.
std::uint64_t usual_obj_bytes(const Surface& surface) {
  constexpr std::uint64_t kUsualLineBytes = 40;
  return kUsualLineBytes * (surface.positions.size() + surface.normals.size() +
                            surface.triangles.size() + surface.lines.size());
}

Result<void> write_comments(SurfaceOutput& file, const Surface& surface,
                            const SurfaceWriteOptions& options) {
  std::string header;
  if (!options.comment.empty()) header += fmt::format("# {}\n", to_one_line(options.comment));
  header += fmt::format("# frame {}\n", name_of(options.frame));
  // Noted even when zero: it tells the reader that the digits are those of float32.
  header += fmt::format("# {} {} {} {}\n", kOriginNote, surface.origin[0], surface.origin[1],
                        surface.origin[2]);
  if (!options.places.empty()) header += fmt::format("# {}\n", kPlacesNote);
  return file.write(header);
}

Result<void> write_vertex_lines(SurfaceOutput& file, const Surface& surface,
                                std::span<const Vec3d> places) {
  const bool is_double = has_origin(surface) || !places.empty();
  LODE_CHECK(write_lines(file, surface.positions.size(), [&](std::size_t i, auto out) {
    if (is_double) {
      const Vec3d p =
          PlacedSurfaceView{surface, places}.world_position(static_cast<std::uint32_t>(i));
      fmt::format_to(out, FMT_COMPILE("v {} {} {}\n"), p[0], p[1], p[2]);
    } else {
      const Vec3f& p = surface.positions[i];
      fmt::format_to(out, FMT_COMPILE("v {} {} {}\n"), p[0], p[1], p[2]);
    }
  }));
  return write_lines(file, surface.normals.size(), [&](std::size_t i, auto out) {
    const Vec3f& n = surface.normals[i];
    fmt::format_to(out, FMT_COMPILE("vn {} {} {}\n"), n[0], n[1], n[2]);
  });
}

Result<void> write_cell_lines(SurfaceOutput& file, const Surface& surface) {
  const bool has_normals = !surface.normals.empty();
  LODE_CHECK(write_lines(file, surface.triangles.size(), [&](std::size_t i, auto out) {
    const std::uint64_t a = std::uint64_t{surface.triangles[i][0]} + 1;
    const std::uint64_t b = std::uint64_t{surface.triangles[i][1]} + 1;
    const std::uint64_t c = std::uint64_t{surface.triangles[i][2]} + 1;
    if (has_normals)
      fmt::format_to(out, FMT_COMPILE("f {}//{} {}//{} {}//{}\n"), a, a, b, b, c, c);
    else
      fmt::format_to(out, FMT_COMPILE("f {} {} {}\n"), a, b, c);
  }));
  return write_lines(file, surface.lines.size(), [&](std::size_t i, auto out) {
    fmt::format_to(out, FMT_COMPILE("l {} {}\n"), std::uint64_t{surface.lines[i][0]} + 1,
                   std::uint64_t{surface.lines[i][1]} + 1);
  });
}

/// One pass over an OBJ file, with coordinates parsed as T.
template <typename T>
class ObjParser {
 public:
  explicit ObjParser(const std::string& path) : path_(path) {}

  Result<void> parse(std::string_view text) {
    for (n_lines_ = 1; !text.empty(); ++n_lines_) {
      std::string_view line = next_line(text);
      line = line.substr(0, line.find('#'));
      const std::string_view keyword = next_word(line);
      if (keyword == "v")
        LODE_CHECK(parse_vertex(line));
      else if (keyword == "vn")
        LODE_CHECK(parse_normal(line));
      else if (keyword == "f" || keyword == "l")
        LODE_CHECK(parse_cell(line, keyword == "f"));
    }
    return {};
  }

  [[nodiscard]] std::vector<Vec<T, 3>>& positions() { return positions_; }

  /// The cells, and the normals if each vertex has one.
  Surface take_cells() {
    Surface surface = std::move(cells_);
    const std::size_t n = positions_.size();
    normal_of_.resize(n, kNoNormal);
    if (normals_.empty() || has_conflict_) return surface;
    const bool is_plain = normals_.size() == n;
    for (std::size_t i = 0; i < n; ++i) {
      // Vertices that no face uses take the normal of their own number, if there are as many.
      if (normal_of_[i] == kNoNormal && is_plain) normal_of_[i] = static_cast<std::uint32_t>(i);
      if (normal_of_[i] >= normals_.size()) return surface;
    }
    surface.normals.resize(n);
    for (std::size_t i = 0; i < n; ++i) surface.normals[i] = normals_[normal_of_[i]];
    return surface;
  }

 private:
  Error line_error(const char* expected, std::string_view got) const {
    return fail("{}: line {}: expected {}, got {}", path_, n_lines_, expected, quoted(got));
  }

  Result<void> parse_vertex(std::string_view line) {
    const std::string_view whole = line;
    Vec<T, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<T> value = parse_number<T>(next_word(line));
      if (!value) return line_error("three coordinates", whole);
      p[k] = *value;
    }
    positions_.push_back(p);
    return {};
  }

  Result<void> parse_normal(std::string_view line) {
    const std::string_view whole = line;
    Vec3f n;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<float> value = to_float(next_word(line));
      if (!value) return line_error("three components of a normal", whole);
      n[k] = *value;
    }
    normals_.push_back(n);
    return {};
  }

  /// Turns "7" or "-1" into an index from 0; counts below zero run back from the last of `n`.
  /// Whether forward ones exist is known, and checked, at the end of the file.
  static std::optional<std::uint32_t> parse_index(std::string_view word, std::size_t n) {
    const std::optional<std::int64_t> number = to_int64(word);
    if (!number || *number == 0 || *number > std::int64_t{kNoNormal}) return std::nullopt;
    if (*number > 0) return static_cast<std::uint32_t>(*number - 1);
    if (*number < -static_cast<std::int64_t>(std::min<std::size_t>(n, kNoNormal)))
      return std::nullopt;
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(n) + *number);
  }

  /// v, v/vt, v//vn or v/vt/vn.
  Result<std::uint32_t> parse_corner(std::string_view word) {
    const std::size_t slash = word.find('/');
    const std::optional<std::uint32_t> vertex =
        parse_index(word.substr(0, slash), positions_.size());
    if (!vertex) return line_error("a vertex number", word);
    const std::size_t last = slash == std::string_view::npos ? slash : word.find('/', slash + 1);
    if (last == std::string_view::npos || last + 1 == word.size()) return *vertex;
    const std::optional<std::uint32_t> normal = parse_index(word.substr(last + 1), normals_.size());
    if (!normal) return line_error("a normal's number", word);
    if (*vertex >= positions_.size()) return *vertex;
    normal_of_.resize(positions_.size(), kNoNormal);
    std::uint32_t& known = normal_of_[*vertex];
    has_conflict_ = has_conflict_ || (known != kNoNormal && known != *normal);
    known = *normal;
    return *vertex;
  }

  Result<void> parse_cell(std::string_view line, bool is_face) {
    corners_.clear();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      LODE_TRY(const std::uint32_t corner, parse_corner(word));
      corners_.push_back(corner);
    }
    if (is_face) return append_polygon(path_, corners_, cells_);
    for (std::size_t i = 1; i < corners_.size(); ++i)
      cells_.lines.push_back({corners_[i - 1], corners_[i]});
    return {};
  }

  template <typename U>
  static std::optional<U> parse_number(std::string_view word) {
    if constexpr (std::is_same_v<U, float>)
      return to_float(word);
    else
      return to_double(word);
  }

  const std::string& path_;
  std::size_t n_lines_ = 0;
  std::vector<Vec<T, 3>> positions_;
  std::vector<Vec3f> normals_;
  std::vector<std::uint32_t> normal_of_;  ///< Per vertex, as far as faces named one.
  std::vector<std::uint32_t> corners_;
  Surface cells_;
  bool has_conflict_ = false;
};

/// What the comments that start the file note.
struct ObjNotes {
  std::optional<Vec3d> origin{};
  bool has_places = false;
};

ObjNotes find_notes(std::string_view text) {
  ObjNotes notes;
  while (text.starts_with('#')) {
    std::string_view comment = next_line(text).substr(1);
    if (!notes.origin) notes.origin = parse_origin_note(comment);
    notes.has_places = notes.has_places || next_word(comment) == kPlacesNote;
  }
  return notes;
}

/// Whether float32 would keep fewer than 18 bits of the extent.
bool is_far_from_zero(const std::vector<Vec3f>& positions) {
  constexpr float kFar = 64;
  if (positions.empty()) return false;
  Vec3f lower = positions.front();
  Vec3f upper = positions.front();
  for (const Vec3f& p : positions)
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], p[k]);
      upper[k] = std::max(upper[k], p[k]);
    }
  float extent = 0;
  float largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    extent = std::max(extent, upper[k] - lower[k]);
    largest = std::max({largest, std::abs(lower[k]), std::abs(upper[k])});
  }
  return positions.size() > 1 && largest > kFar * extent;
}

Result<PlacedSurface> read_as_double(const std::string& path, std::string_view text,
                                     const std::optional<Vec3d>& note) {
  ObjParser<double> parser(path);
  LODE_CHECK(parser.parse(text));
  Surface surface = parser.take_cells();
  LODE_TRY(std::vector<Vec3d> places,
           place_positions(path, std::move(parser.positions()), note, surface));
  LODE_CHECK(check_surface(path, surface));
  return PlacedSurface{std::move(surface), std::move(places)};
}

}  // namespace

Result<void> write_obj(const std::string& path, const Surface& surface,
                       const SurfaceWriteOptions& options, Progress& progress) {
  LODE_TRY(SurfaceOutput file,
           SurfaceOutput::create(path, usual_obj_bytes(surface), progress, options.threads));
  LODE_CHECK(write_comments(file, surface, options));
  LODE_CHECK(write_vertex_lines(file, surface, options.places));
  LODE_CHECK(write_cell_lines(file, surface));
  return file.commit();
}

Result<PlacedSurface> read_obj(const std::string& path) {
  LODE_TRY(const SurfaceBytes file, SurfaceBytes::load(path));
  const auto [note, has_places] = find_notes(file.text());
  if (has_places || (note && *note != Vec3d{})) return read_as_double(path, file.text(), note);
  ObjParser<float> parser(path);
  LODE_CHECK(parser.parse(file.text()));
  if (!note && is_far_from_zero(parser.positions())) return read_as_double(path, file.text(), note);
  Surface surface = parser.take_cells();
  surface.positions = std::move(parser.positions());
  LODE_CHECK(check_surface(path, surface));
  return PlacedSurface{std::move(surface)};
}

}  // namespace lode::io
