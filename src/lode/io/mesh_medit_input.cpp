#include "lode/io/mesh_medit_input.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <utility>

#include "lode/io/text.h"

namespace lode::io {
namespace {

/// Keywords that Lode knows, by their numbers in binary files (libMeshb).
constexpr std::array<std::pair<std::int64_t, std::string_view>, 24> kCodes{
    {{3, "dimension"},
     {4, "vertices"},
     {5, "edges"},
     {6, "triangles"},
     {7, "quadrilaterals"},
     {8, "tetrahedra"},
     {9, "prisms"},
     {10, "hexahedra"},
     {24, "trianglesp2"},
     {25, "edgesp2"},
     {27, "quadrilateralsq2"},
     {30, "tetrahedrap2"},
     {33, "hexahedraq2"},
     {49, "pyramids"},
     {54, "end"},
     {62, "solatvertices"},
     {63, "solatedges"},
     {64, "solattriangles"},
     {65, "solatquadrilaterals"},
     {66, "solattetrahedra"},
     {67, "solatprisms"},
     {68, "solathexahedra"},
     {86, "prismsp2"},
     {87, "pyramidsp2"}}};

constexpr std::string_view kLittle("\x01\0\0\0", 4);
constexpr std::string_view kBig("\0\0\0\x01", 4);

}  // namespace

Result<MeditInput> MeditInput::open(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(MeshText text, MeshText::open(path, options));
  MeditInput input(std::move(text));
  const std::string_view start = input.text_.start(kLittle.size());
  if (start == kLittle || start == kBig) {
    input.order_ = start == kLittle ? ByteOrder::little : ByteOrder::big;
    LODE_CHECK(input.read_binary_head());
    return input;
  }
  input.text_.blank_comments('#');
  const std::string first = to_lower(input.text_.word());
  if (first != "meshversionformatted")
    return fail("{}: expected MeshVersionFormatted, or binary MEDIT, got {}", path,
                in_quotes(first));
  return input;
}

Result<void> MeditInput::read_binary_head() {
  is_binary_ = true;
  LODE_TRY([[maybe_unused]] const std::int64_t one, text_.binary_whole(ScalarType::int32, order_));
  LODE_TRY(version_, text_.binary_whole(ScalarType::int32, order_));
  if (version_ < 1 || version_ > 4)
    return fail("{}: expected binary MEDIT of version 1 to 4, got {}", path(), version_);
  next_ = text_.position();
  return {};
}

Result<std::string> MeditInput::binary_keyword(std::string_view before) {
  if (next_ == 0) return std::string();
  if (!before.empty() && text_.position() < next_)
    return fail(
        "{}: expected a keyword at byte {}, behind as many {} as the file says, got byte {}",
        path(), text_.position(), before, next_);
  // Else many keywords could take the same bytes as their data, again and again.
  if (text_.position() > next_)
    return fail(
        "{}: expected data that end before the next keyword at byte {}, got some to byte {}",
        path(), next_, text_.position());
  LODE_CHECK(text_.seek(next_));
  LODE_TRY(const std::int64_t code, text_.binary_whole(ScalarType::int32, order_));
  LODE_TRY(const std::int64_t next,
           text_.binary_whole(version_ < 3 ? ScalarType::int32 : ScalarType::int64, order_));
  // Positions rise, so that no chain of them is endless.
  if (next != 0 && (next < 0 || std::cmp_less_equal(next, next_)))
    return fail("{}: expected the next keyword behind byte {}, got {}", path(), next_, next);
  next_ = static_cast<std::size_t>(next);
  for (const auto& [number, name] : kCodes)
    if (number == code) return std::string(name);
  return std::to_string(code);
}

Result<std::string> MeditInput::keyword(std::string_view before) {
  if (is_binary_) return binary_keyword(before);
  const std::string_view word = text_.word();
  if (!before.empty() && to_double(word))
    return fail("{}: expected a keyword behind as many {} as the file says, got {}", where(),
                before, in_quotes(word));
  return to_lower(word);
}

std::string MeditInput::where() const {
  if (is_binary_) return fmt::format("{}: before byte {}", path(), text_.position());
  return fmt::format("{}: line {}", path(), text_.line_number());
}

Result<std::int64_t> MeditInput::number(std::string_view what, ScalarType type, std::int64_t low,
                                        std::int64_t high) {
  if (is_binary_) {
    LODE_TRY(const std::int64_t found, text_.binary_whole(type, order_));
    if (found >= low && found <= high) return found;
    return fail("{}: expected {} from {} to {}, got {}", where(), what, low, high, found);
  }
  const std::string_view word = text_.word();
  const auto found = to_int64(word);
  if (found && *found >= low && *found <= high) return *found;
  return fail("{}: expected {} from {} to {}, got {}", where(), what, low, high, in_quotes(word));
}

Result<std::int64_t> MeditInput::whole(std::string_view what, std::int64_t low, std::int64_t high) {
  return number(what, version_ < 4 ? ScalarType::int32 : ScalarType::int64, low, high);
}

Result<std::int64_t> MeditInput::small(std::string_view what, std::int64_t low, std::int64_t high) {
  return number(what, ScalarType::int32, low, high);
}

Result<void> MeditInput::expect_three_dimensions(std::string_view what) {
  LODE_TRY(const std::int64_t n, small("a dimension", 0, 99));
  if (n == 3) return {};
  return fail("{}: expected {} of 3 dimensions, got {}", where(), what, n);
}

Result<double> MeditInput::real(std::string_view what) {
  if (is_binary_)
    return text_.binary_real(order_, version_ == 1 ? ScalarType::float32 : ScalarType::float64);
  const std::string_view word = text_.word();
  if (const auto found = to_double(word)) return *found;
  return fail("{}: expected {}, got {}", where(), what, in_quotes(word));
}

}  // namespace lode::io
