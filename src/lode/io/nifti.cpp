#include "lode/io/nifti.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "lode/io/deflated_samples.h"
#include "lode/io/image_grid.h"
#include "lode/io/inflate.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::size_t kHeaderSize1 = 348;
constexpr std::size_t kHeaderSize2 = 540;

/// The header's bytes and how to read numbers out of them.
struct HeaderBytes {
  std::vector<std::byte> bytes;
  ByteOrder order = ByteOrder::little;

  template <typename T>
  T get(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    const bool is_native =
        (order == ByteOrder::little) == (std::endian::native == std::endian::little);
    if (!is_native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
};

/// What both versions hold, in the wider version's types.
struct NiftiHeader {
  int version = 1;
  ByteOrder order = ByteOrder::little;
  bool is_single_file = true;
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int units = 0;  ///< Of lengths in the lowest three bits, of times above.
  int datatype = 0;
  double vox_offset = 0;
  double slope = 0;
  double intercept = 0;
  int qform_code = 0;
  int sform_code = 0;
  std::array<double, 6> quaternion{};  ///< b, c, d, and the offsets x, y, z.
  std::array<double, 12> srow{};
};

bool is_gzip(const std::string& path) { return to_lower(path).ends_with(".gz"); }

Result<std::vector<std::byte>> read_start(const InputFilePtr& file, std::size_t n_bytes) {
  std::vector<std::byte> bytes(n_bytes);
  std::size_t n = 0;
  if (is_gzip(file->path())) {
    InflateStream stream(make_file_stream(file, 0), file->path());
    LODE_TRY(n, stream.read_some(bytes));
  } else {
    n = static_cast<std::size_t>(std::min<std::uint64_t>(n_bytes, file->size()));
    LODE_CHECK(file->read(0, std::span(bytes).first(n)));
  }
  bytes.resize(n);
  return bytes;
}

Result<HeaderBytes> read_header_bytes(const InputFilePtr& file) {
  HeaderBytes header;
  LODE_TRY(header.bytes, read_start(file, kHeaderSize2));
  if (header.bytes.size() < kHeaderSize1)
    return fail("{}: expected a NIfTI header of {} bytes, got {}", file->path(), kHeaderSize1,
                header.bytes.size());
  for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
    header.order = order;
    const auto size = header.get<std::int32_t>(0);
    if (size == static_cast<std::int32_t>(kHeaderSize1)) return header;
    if (size != static_cast<std::int32_t>(kHeaderSize2)) continue;
    if (header.bytes.size() == kHeaderSize2) return header;
    return fail("{}: expected a NIfTI-2 header of {} bytes, got {}", file->path(), kHeaderSize2,
                header.bytes.size());
  }
  return fail("{}: expected a NIfTI header of size 348 or 540, got size {}", file->path(),
              header.get<std::int32_t>(0));
}

NiftiHeader parse_version_1(const HeaderBytes& b) {
  NiftiHeader h{.version = 1, .order = b.order};
  for (std::size_t i = 0; i < 8; ++i) {
    h.dim[i] = b.get<std::int16_t>(40 + 2 * i);
    h.pixdim[i] = double{b.get<float>(76 + 4 * i)};
  }
  h.datatype = b.get<std::int16_t>(70);
  h.units = b.get<std::uint8_t>(123);
  h.vox_offset = double{b.get<float>(108)};
  h.slope = double{b.get<float>(112)};
  h.intercept = double{b.get<float>(116)};
  h.qform_code = b.get<std::int16_t>(252);
  h.sform_code = b.get<std::int16_t>(254);
  for (std::size_t i = 0; i < 6; ++i) h.quaternion[i] = double{b.get<float>(256 + 4 * i)};
  for (std::size_t i = 0; i < 12; ++i) h.srow[i] = double{b.get<float>(280 + 4 * i)};
  return h;
}

NiftiHeader parse_version_2(const HeaderBytes& b) {
  NiftiHeader h{.version = 2, .order = b.order};
  for (std::size_t i = 0; i < 8; ++i) {
    h.dim[i] = b.get<std::int64_t>(16 + 8 * i);
    h.pixdim[i] = b.get<double>(104 + 8 * i);
  }
  h.datatype = b.get<std::int16_t>(12);
  h.units = b.get<std::int32_t>(500);
  h.vox_offset = static_cast<double>(b.get<std::int64_t>(168));
  h.slope = b.get<double>(176);
  h.intercept = b.get<double>(184);
  h.qform_code = b.get<std::int32_t>(344);
  h.sform_code = b.get<std::int32_t>(348);
  for (std::size_t i = 0; i < 6; ++i) h.quaternion[i] = b.get<double>(352 + 8 * i);
  for (std::size_t i = 0; i < 12; ++i) h.srow[i] = b.get<double>(400 + 8 * i);
  return h;
}

Result<NiftiHeader> read_nifti_header(const InputFilePtr& file) {
  LODE_TRY(const HeaderBytes bytes, read_header_bytes(file));
  const bool is_version_2 = bytes.get<std::int32_t>(0) == static_cast<std::int32_t>(kHeaderSize2);
  NiftiHeader header = is_version_2 ? parse_version_2(bytes) : parse_version_1(bytes);
  std::string magic(3, '\0');
  std::memcpy(magic.data(), bytes.bytes.data() + (is_version_2 ? 4 : 344), 3);
  const std::string single = is_version_2 ? "n+2" : "n+1";
  const std::string pair = is_version_2 ? "ni2" : "ni1";
  if (magic != single && magic != pair)
    return fail("{}: expected the NIfTI magic {} or {}, got {} (Analyze files say too little)",
                file->path(), single, pair, in_quotes(magic));
  header.is_single_file = magic == single;
  return header;
}

struct NiftiType {
  ScalarType type;
  std::int64_t n_components;
};

Result<NiftiType> parse_nifti_type(const std::string& path, int datatype) {
  switch (datatype) {
    case 2: return NiftiType{ScalarType::uint8, 1};
    case 4: return NiftiType{ScalarType::int16, 1};
    case 8: return NiftiType{ScalarType::int32, 1};
    case 16: return NiftiType{ScalarType::float32, 1};
    case 64: return NiftiType{ScalarType::float64, 1};
    case 128: return NiftiType{ScalarType::uint8, 3};
    case 256: return NiftiType{ScalarType::int8, 1};
    case 512: return NiftiType{ScalarType::uint16, 1};
    case 768: return NiftiType{ScalarType::uint32, 1};
    case 1024: return NiftiType{ScalarType::int64, 1};
    case 1280: return NiftiType{ScalarType::uint64, 1};
    case 2304: return NiftiType{ScalarType::uint8, 4};
    default:
      return fail("{}: expected integer, float or RGB samples, got NIfTI datatype {}", path,
                  datatype);
  }
}

/// Space, time and vector sizes: dim[1..3], dim[4], dim[5].
Result<std::array<std::int64_t, 5>> parse_counts(const std::string& path, const NiftiHeader& h) {
  const std::int64_t n = h.dim[0];
  if (n < 1 || n > 7) return fail("{}: expected 1 to 7 NIfTI dimensions, got {}", path, n);
  std::array<std::int64_t, 5> counts = {1, 1, 1, 1, 1};
  for (std::size_t i = 1; i <= static_cast<std::size_t>(n); ++i) {
    if (i <= 5)
      counts[i - 1] = h.dim[i];
    else if (h.dim[i] > 1)
      return fail("{}: expected at most 5 dimensions in use, got {} along dimension {}", path,
                  h.dim[i], i);
  }
  return counts;
}

/// The standard's method 2: a rotation by a unit quaternion, spacings, and qfac for mirrored z. Of
/// half a turn, and where b, c and d are more than a unit, they are scaled to one, as the
/// standard's own library does.
GridFrame frame_from_quaternion(const NiftiHeader& h) {
  constexpr double kHalfTurn = 1e-7;
  auto [b, c, d, x, y, z] = h.quaternion;
  const double square = b * b + c * c + d * d;
  double a = 0;
  if (1 - square < kHalfTurn) {
    const double scale = 1 / std::sqrt(square);
    b *= scale;
    c *= scale;
    d *= scale;
  } else {
    a = std::sqrt(1 - square);
  }
  const double qfac = h.pixdim[0] < 0 ? -1 : 1;
  GridFrame frame;
  frame.origin = {{x, y, z}};
  frame.direction.rows = {
      Vec3d{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c) * qfac}},
      Vec3d{{2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b) * qfac}},
      Vec3d{{2 * (b * d - a * c), 2 * (c * d + a * b), (a * a + d * d - b * b - c * c) * qfac}}};
  return frame;
}

Result<RegularGrid> parse_nifti_grid(const std::string& path, const NiftiHeader& h,
                                     const Index3& dims, std::string& frame_note) {
  if (h.sform_code > 0) {
    frame_note = fmt::format("sform, code {}", h.sform_code);
    GridSteps steps{.dims = dims, .steps = {}, .frame = Frame::ras};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) steps.steps[axis][row] = h.srow[row * 4 + axis];
      steps.origin[row] = h.srow[row * 4 + 3];
    }
    return make_grid(path, steps);
  }
  GridFrame frame;
  if (h.qform_code > 0) {
    frame_note = fmt::format("qform, code {}", h.qform_code);
    frame = frame_from_quaternion(h);
    frame.frame = Frame::ras;
  } else {
    frame_note = "the header has neither sform nor qform";
  }
  frame.dims = dims;
  frame.spacing = {{h.pixdim[1], h.pixdim[2], h.pixdim[3]}};
  return make_grid(path, frame);
}

/// Empty where the header says none.
std::string length_unit_of(const NiftiHeader& h) {
  constexpr std::array<const char*, 8> kUnits = {"", "m", "mm", "um", "", "", "", ""};
  return kUnits[static_cast<std::size_t>(h.units & 7)];
}

Result<SampleLayout> make_layout(const std::string& path, const NiftiHeader& h, const Index3& dims,
                                 const std::array<std::int64_t, 5>& counts, NiftiType type) {
  const bool is_vector = counts[4] > 1;
  if (is_vector && type.n_components > 1)
    return fail("{}: expected vectors or RGB samples, got both", path);
  // Vector components lie behind one another as whole volumes (dimension 5).
  LODE_TRY(SampleLayout layout,
           interleaved_layout(path, dims, type.type, type.n_components, counts[3]));
  if (is_vector) {
    const std::array<std::int64_t, 5> sizes = {dims[0], dims[1], dims[2], counts[3], counts[4]};
    LODE_TRY(layout.n_bytes, checked_n_bytes(path, sizes, size_of(type.type)));
    layout.n_components = counts[4];
    layout.component_stride = layout.time_stride * counts[3];
  } else if (counts[4] < 1) {
    return fail("{}: expected a size of at least 1 along dimension 5, got {}", path, counts[4]);
  }
  layout.byte_order = h.order;
  return layout;
}

/// x.hdr -> x.img, keeping .gz and the letters' case.
std::string image_beside(const std::string& path) {
  std::string other = path;
  const std::size_t end = other.size() - (is_gzip(path) ? 3 : 0);
  const bool is_upper = other[end - 1] == 'R' || other[end - 1] == 'G';
  return other.replace(end - 3, 3, is_upper ? "IMG" : "img");
}

std::string header_beside(const std::string& path) {
  const std::string lower = to_lower(path);
  if (!lower.ends_with(".img") && !lower.ends_with(".img.gz")) return path;
  std::string other = path;
  const std::size_t end = other.size() - (is_gzip(path) ? 3 : 0);
  return other.replace(end - 3, 3, other[end - 1] == 'G' ? "HDR" : "hdr");
}

Result<std::uint64_t> parse_offset(const std::string& path, const NiftiHeader& h) {
  const std::size_t header_size = h.version == 2 ? kHeaderSize2 : kHeaderSize1;
  const double lowest = h.is_single_file ? static_cast<double>(header_size) : 0;
  // Some writers leave 0 for "right behind the header and its four extension bytes".
  if (h.is_single_file && h.vox_offset == 0) return std::uint64_t{header_size} + 4;
  constexpr double kMaxOffset = 1e15;
  if (!(h.vox_offset >= lowest && h.vox_offset < kMaxOffset))
    return fail("{}: expected a vox_offset of at least {}, got {}", path, lowest, h.vox_offset);
  return static_cast<std::uint64_t>(h.vox_offset);
}

}  // namespace

Result<Image> read_nifti(const std::string& path, const SampleStorage& storage) {
  LODE_TRY(const InputFilePtr file, InputFile::open(header_beside(path)));
  LODE_TRY(const NiftiHeader header, read_nifti_header(file));
  LODE_TRY(const auto counts, parse_counts(path, header));
  LODE_TRY(const Index3 dims, checked_dims(path, std::span(counts).first(3)));
  LODE_TRY(const NiftiType type, parse_nifti_type(path, header.datatype));
  const bool is_compressed = is_gzip(path);
  Image image{.path = path,
              .format = fmt::format("NIfTI-{}{}", header.version, is_compressed ? ", gzip" : ""),
              .frame_note = {},
              .grid = {},
              .fields = {},
              .tally = file->tally()};
  LODE_TRY(image.grid, parse_nifti_grid(path, header, dims, image.frame_note));
  image.length_unit = length_unit_of(header);
  ImageField field;
  LODE_TRY(field.layout, make_layout(path, header, dims, counts, type));
  const bool has_scale = std::isfinite(header.slope) && header.slope != 0 && type.n_components == 1;
  if (has_scale) {
    field.slope = header.slope;
    field.intercept = std::isfinite(header.intercept) ? header.intercept : 0;
  }
  LODE_TRY(const std::uint64_t offset, parse_offset(path, header));
  InputFilePtr data = file;
  if (!header.is_single_file) {
    LODE_TRY(data, InputFile::open(image_beside(file->path()), file->tally()));
  }
  const std::uint64_t n_bytes = field.layout.n_bytes;
  field.load = [data, offset, n_bytes, is_compressed, storage] {
    return is_compressed
               ? load_inflated({.file = data, .n_skipped = offset, .n_bytes = n_bytes}, storage)
               : make_file_store(data, offset, n_bytes);
  };
  image.fields.push_back(std::move(field));
  return image;
}

}  // namespace lode::io
