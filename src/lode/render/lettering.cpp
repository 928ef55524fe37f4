#include "lode/render/lettering.h"

#include <fontconfig/fontconfig.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace lode {
namespace {

constexpr const char* kNoFont =
    "letters: expected a font that Fontconfig finds, such as that of the package "
    "fonts-dejavu-core, got none";

/// The file of the font for "sans-serif"; empty where there is none.
std::string font_path() {
  FcConfig* const config = FcInitLoadConfigAndFonts();
  if (config == nullptr) return {};
  FcPattern* const wanted = FcNameParse(reinterpret_cast<const FcChar8*>("sans-serif"));
  FcConfigSubstitute(config, wanted, FcMatchPattern);
  FcDefaultSubstitute(wanted);
  FcResult result = FcResultNoMatch;
  FcPattern* const found = FcFontMatch(config, wanted, &result);
  std::string path;
  FcChar8* file = nullptr;
  if (found != nullptr && FcPatternGetString(found, FC_FILE, 0, &file) == FcResultMatch)
    path = reinterpret_cast<const char*>(file);
  if (found != nullptr) FcPatternDestroy(found);
  FcPatternDestroy(wanted);
  FcConfigDestroy(config);
  return path;
}

/// The next character of UTF-8, which is taken away.
char32_t next_character(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  const std::size_t n = lead < 0x80   ? 1
                        : lead < 0xC0 ? 0
                        : lead < 0xE0 ? 2
                        : lead < 0xF0 ? 3
                        : lead < 0xF8 ? 4
                                      : 0;
  bool is_valid = n > 0 && n <= text.size();
  char32_t character = n == 1 ? lead : lead & (0xFFU >> (n + 1));
  for (std::size_t i = 1; is_valid && i < n; ++i) {
    is_valid = (byte(i) & 0xC0U) == 0x80;
    character = character << 6U | (byte(i) & 0x3FU);
  }
  text.remove_prefix(is_valid ? n : 1);
  return is_valid && character >= U' ' ? character : U'?';
}

}  // namespace

struct Lettering::Impl {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// Calls visit(glyph, x) for each letter that there is, x being where it begins; returns where
  /// the text ends.
  template <typename Visit>
  int walk(std::string_view text, const Visit& visit) const {
    constexpr int kPixel = 64;  // FreeType counts in these parts of one.
    int x = 0;
    while (!text.empty()) {
      if (FT_Load_Char(face, next_character(text), FT_LOAD_RENDER) != 0) continue;
      visit(*face->glyph, x);
      x += static_cast<int>(face->glyph->advance.x / kPixel);
    }
    return x;
  }
};

Lettering::Lettering(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Lettering::Lettering(Lettering&&) noexcept = default;
Lettering& Lettering::operator=(Lettering&&) noexcept = default;
Lettering::~Lettering() = default;

Result<Lettering> Lettering::open(int size) {
  // Reading what fonts there are takes longer than a legend, and films have one a frame.
  static const std::string kPath = font_path();
  const std::string& path = kPath;
  if (path.empty()) return fail(kNoFont);
  auto impl = std::make_unique<Impl>();
  if (FT_Init_FreeType(&impl->library) != 0) return fail("letters: FreeType does not start");
  if (FT_New_Face(impl->library, path.c_str(), 0, &impl->face) != 0)
    return fail("{}: expected a font that FreeType reads, got another file", path);
  if (FT_Set_Pixel_Sizes(impl->face, 0, static_cast<FT_UInt>(std::max(size, 1))) != 0)
    return fail("{}: expected a font of any size, got one that has none of {} pixels", path, size);
  return Lettering(std::move(impl));
}

int Lettering::width(std::string_view text) const {
  return impl_->walk(text, [](const FT_GlyphSlotRec&, int) {});
}

int Lettering::height() const {
  int height = 0;
  impl_->walk("0", [&](const FT_GlyphSlotRec& glyph, int) { height = glyph.bitmap_top; });
  return height;
}

void Lettering::write(std::string_view text, int x, int y, Color color, Image& image) const {
  constexpr double kOpaque = 255;
  impl_->walk(text, [&](const FT_GlyphSlotRec& glyph, int along) {
    const FT_Bitmap& bitmap = glyph.bitmap;
    if (bitmap.pixel_mode != FT_PIXEL_MODE_GRAY) return;
    for (unsigned row = 0; row < bitmap.rows; ++row)
      for (unsigned column = 0; column < bitmap.width; ++column) {
        const int px = x + along + glyph.bitmap_left + static_cast<int>(column);
        const int py = y - glyph.bitmap_top + static_cast<int>(row);
        if (px < 0 || px >= image.width || py < 0 || py >= image.height) continue;
        const unsigned char covered =
            bitmap.buffer[static_cast<std::ptrdiff_t>(row) * bitmap.pitch + column];
        blend(color, covered / kOpaque,
              image.pixels[static_cast<std::size_t>(py) * static_cast<std::size_t>(image.width) +
                           static_cast<std::size_t>(px)]);
      }
  });
}

void blend(Color color, double coverage, Color& pixel) {
  constexpr double kOpaque = 255;
  const double over = coverage * color.a / kOpaque;
  const double under = (1 - over) * pixel.a / kOpaque;
  const double alpha = over + under;
  if (!(alpha > 0)) return;
  const auto mixed = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround((over * a + under * b) / alpha));
  };
  pixel = {mixed(color.r, pixel.r), mixed(color.g, pixel.g), mixed(color.b, pixel.b),
           static_cast<std::uint8_t>(std::lround(alpha * kOpaque))};
}

}  // namespace lode
