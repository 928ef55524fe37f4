#include "lode/render/image.h"

#include <png.h>

#include <algorithm>
#include <new>
#include <utility>

#include "lode/core/atomic_file.h"
#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

static_assert(sizeof(Color) == 4, "Color is handed to libpng as RGBA bytes");

std::vector<std::uint8_t> rgb_bytes(const Image& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.pixels.size() * 3);
  for (const Color& pixel : image.pixels) bytes.insert(bytes.end(), {pixel.r, pixel.g, pixel.b});
  return bytes;
}

}  // namespace

Result<std::vector<std::byte>> encode_png(const Image& image) try {
  LODE_EXPECTS(image.width > 0 && image.height > 0 &&
               image.pixels.size() ==
                   static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const bool is_opaque = std::all_of(image.pixels.begin(), image.pixels.end(),
                                     [](const Color& pixel) { return pixel.a == 255; });
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = is_opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  const std::vector<std::uint8_t> rgb = is_opaque ? rgb_bytes(image) : std::vector<std::uint8_t>{};
  const void* pixels = is_opaque ? static_cast<const void*>(rgb.data()) : image.pixels.data();

  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, pixels, 0, nullptr) == 0) {
    Error error = fail("PNG of {} x {} pixels: libpng: {}", image.width, image.height,
                       static_cast<const char*>(header.message));
    png_image_free(&header);
    return error;
  }
  bytes.resize(size);
  return bytes;
} catch (const std::bad_alloc&) {
  return out_of_memory("encode the picture");
}

Result<void> write_png(const Image& image, const std::string& path) try {
  LODE_TRY(const std::vector<std::byte> bytes, encode_png(image));
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  LODE_CHECK(file.write(bytes));
  return file.commit();
} catch (const std::bad_alloc&) {
  return out_of_memory("write the picture", path);
}

}  // namespace lode
